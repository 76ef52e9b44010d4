// A call that must succeed: otherwise the test fails with the library's message.
#ifndef QC_TESTS_SUPPORT_CHECK_OK_H
#define QC_TESTS_SUPPORT_CHECK_OK_H

#include "quickcullide/base.h"

#include <check.h>

#define CHECK_OK(call)                                                                                                 \
    do                                                                                                                 \
    {                                                                                                                  \
        qcStatus checked = (call);                                                                                     \
        ck_assert_msg(checked == qc_statusOk, "%s: %s", #call, qcLastMessage());                                       \
    } while (0)

#endif
