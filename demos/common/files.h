// Output of the benchmarks: a folder, CSVs, and the pictures that gnuplot draws from a script.
//
// Thread-safety: one thread.
#ifndef QC_DEMOS_COMMON_FILES_H
#define QC_DEMOS_COMMON_FILES_H

#include "common/output_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Makes a folder, with all folders above it.
bool qcFiles_MakeFolder(const char* path, qcMessage* message);

/// False: no such file. True even if the file can't be read.
bool qcFiles_IsThere(const char* path);

/// Makes the folder and checks that "FOLDER/NAME" can be written. Call it before long work.
bool qcFiles_Check(const char* folder, const char* name, qcMessage* message);

/// Opens "FOLDER/NAME" by qcOutput_Open.
bool qcFiles_Open(const char* folder, const char* name, qcOutput* output, qcMessage* message);

/// Writes a field of a CSV, in quotes.
void qcFiles_WriteQuoted(FILE* stream, const char* text);

/// Runs "gnuplot SCRIPT" in the folder. Without gnuplot it prints a message on standard error. False: gnuplot failed.
bool qcFiles_Draw(const char* folder, const char* script, qcMessage* message);

#ifdef __cplusplus
}
#endif

#endif
