// The version of the library, as it was when it was compiled.
#include <quickcullide/base.h>

uint32_t qcVersion(void)
{
    return QC_VERSION;
}
