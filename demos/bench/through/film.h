// The film of `qc-bench through`: a cloth thrown at 20 m/s and 60 Hz at one whose corners are fixed, by version 0.2.0
// and by this one, side by side.
#ifndef QC_DEMOS_BENCH_THROUGH_FILM_H
#define QC_DEMOS_BENCH_THROUGH_FILM_H

#include "common/exit_status.h"
#include "common/message.h"

#include <cstddef>

/// Simulates the scene and draws both into FOLDER/frame_0000.png and so on; the positions of 0.2.0 are recorded ones,
/// which are part of the program. Counts the pictures. Fills the message unless it returns qc_exitDone.
qcExitStatus qcDrawThroughFilm(const char* folder, int picturesPerStep, size_t* pictures, qcMessage* message);

/// Simulates the scene and writes the positions at the ends of steps to a file: how before_film.txt was made.
bool qcRecordThroughFilm(const char* path, qcMessage* message);

#endif
