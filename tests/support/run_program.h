// Runs a program as a user would, in a folder of its own, and keeps what it said.
#ifndef QC_TESTS_SUPPORT_RUN_PROGRAM_H
#define QC_TESTS_SUPPORT_RUN_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>

/// What the last program wrote to standard output and standard error.
const char* GetOutput(void);
const char* GetErrors(void);

/// Makes an empty folder and goes there; the second removes it with all it holds.
void EnterFolder(void);
void LeaveFolder(void);

/// Runs a command line of the shell and returns its exit status, or 128 + the signal that ended it.
__attribute__((format(printf, 1, 2))) int Run(const char* format, ...);

void WriteText(const char* path, const char* text);
/// Reads a file into `text`, ended by a zero; false: there is none.
bool ReadText(const char* path, char* text, size_t size);
/// Entries of the folder, without "." and "..".
size_t CountEntries(void);

#endif
