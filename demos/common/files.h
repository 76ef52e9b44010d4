// What every benchmark leaves behind: a folder, a CSV, a gnuplot script and the pictures it draws.
//
// Thread-safety: one thread.
#ifndef QC_DEMOS_COMMON_FILES_H
#define QC_DEMOS_COMMON_FILES_H

#include "common/output_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/// With all folders above it.
bool qcFiles_MakeFolder(const char* path, qcMessage* message);

/// False: no such file. One that is there and can't be read is there.
bool qcFiles_IsThere(const char* path);

/// Makes the folder and says early whether "FOLDER/NAME" can be written.
bool qcFiles_Check(const char* folder, const char* name, qcMessage* message);

/// qcOutput_Open of "FOLDER/NAME".
bool qcFiles_Open(const char* folder, const char* name, qcOutput* output, qcMessage* message);

/// A field of a CSV, in quotes.
void qcFiles_WriteQuoted(FILE* stream, const char* text);

/// Runs "gnuplot SCRIPT" in the folder; without gnuplot a word on standard error. False: gnuplot failed.
bool qcFiles_Draw(const char* folder, const char* script, qcMessage* message);

#ifdef __cplusplus
}
#endif

#endif
