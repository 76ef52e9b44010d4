// A file that appears under its name only when it is complete: until then the old one stays. A symbolic link stays a
// link: the file at its end is replaced, or created.
//
// Thread-safety: one thread; a few files may be open at once.
#ifndef QC_DEMOS_COMMON_OUTPUT_FILE_H
#define QC_DEMOS_COMMON_OUTPUT_FILE_H

#include "common/message.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcOutput
{
    FILE* stream;    ///< write here
    char* path;      ///< behind symbolic links
    char* temporary; ///< beside the path; null where the path is no regular file and is written directly
} qcOutput;

/// Checks that the path can be written, and leaves nothing behind; call it before long work.
bool qcOutput_Check(const char* path, qcMessage* message);

/// Opens a temporary file beside the path, in the folder of the file that is replaced. A signal that ends the program
/// removes it.
bool qcOutput_Open(const char* path, qcOutput* output, qcMessage* message);

/// Gives the file its name. On failure (a full disk shows here at the latest) the old file is as it was.
bool qcOutput_Commit(qcOutput* output, qcMessage* message);

/// Closes and removes the temporary file.
void qcOutput_Abort(qcOutput* output);

/// True if both paths are of one regular file, or would be of one where it is not there yet.
bool qcOutput_IsSame(const char* path, const char* other);

#ifdef __cplusplus
}
#endif

#endif
