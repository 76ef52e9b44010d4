// When a lost device is opened again: after a pause that doubles with each failure, and with each loss that soon
// follows.
#ifndef QC_GL_REOPENING_H
#define QC_GL_REOPENING_H

#include <stdbool.h>

typedef struct qcReopening
{
    double firstPause; ///< ms; below 0: never
    double pause;      ///< ms, of the next failure or loss
    double due;        ///< time of the next attempt
    double opened;     ///< time of the last success
} qcReopening;

/// A device that has just been opened, by its definition. `firstPause` in ms.
qcReopening qcReopening_Begin(double firstPause, double now);
/// The device was lost, or an attempt failed.
void qcReopening_Fail(qcReopening* reopening, double now);
/// An attempt succeeded.
void qcReopening_Succeed(qcReopening* reopening, double now);
/// Whether it is time for an attempt. The device is lost.
bool qcReopening_IsDue(const qcReopening* reopening, double now);

#endif
