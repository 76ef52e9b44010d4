// Which GL devices the tests of this run have. By itself in a list of tests: where no device opens it is skipped, so
// that the list shows it; where one that is required doesn't open it fails.
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
        printf("Skipped: no GL device opened\n"); // what device.cmake looks for
    qcCloseTestDevices(devices);
}
END_TEST

QC_RUN_TESTS("GL devices", every_required_gl_device_opens)
