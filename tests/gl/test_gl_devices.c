// The GL devices of this test run. A test of its own: skipped where no device opens, so that the list of tests shows
// it; failed where a required device doesn't open.
#include "support/devices.h"
#include "support/suite.h"

START_TEST(every_required_gl_device_opens)
{
    qcDevice* devices[qc_testDeviceCount];
    int count = qcOpenTestDevices(devices);
    for (int i = 0; i < qc_testDeviceCount; i++)
    {
        if (devices[i] == NULL)
            continue;
        qcDeviceInfo info;
        ck_assert_int_eq(qcDevice_GetInfo(devices[i], &info), qc_statusOk);
        ck_assert(!info.lost);
        printf("%s: %s, GL %s\n", qc_testDeviceNames[qcGetTestName(i)], info.renderer, info.version);
    }
    if (count == 0)
        printf("Skipped: no GL device opened\n"); // device.cmake searches for this line
    qcCloseTestDevices(devices);
}
END_TEST

QC_RUN_TESTS("GL devices", every_required_gl_device_opens)
