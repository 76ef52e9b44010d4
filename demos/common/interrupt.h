// Ctrl-C as a question: the program asks whether it came, ends what it is at, and says what it has done.
//
// Thread-safety: any thread.
#ifndef QC_DEMOS_COMMON_INTERRUPT_H
#define QC_DEMOS_COMMON_INTERRUPT_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// From here on the first SIGINT or SIGTERM is kept; a second one ends the program. One that is ignored (nohup) stays
/// so.
void qcInterrupt_Watch(void);

/// The signal that came, or 0.
int qcInterrupt_Signal(void);

#ifdef __cplusplus
}
#endif

#endif
