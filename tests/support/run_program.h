// Runs a program as a user would, in a folder of its own, and keeps its output.
#ifndef QC_TESTS_SUPPORT_RUN_PROGRAM_H
#define QC_TESTS_SUPPORT_RUN_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The last program's standard output and standard error.
const char* GetOutput(void);
const char* GetErrors(void);

/// Creates an empty folder and changes to it; the second function removes it with its contents.
void EnterFolder(void);
void LeaveFolder(void);

/// Runs a command line of the shell and returns its exit status, or 128 + the signal that ended it.
__attribute__((format(printf, 1, 2))) int Run(const char* format, ...);

/// A mistake on a command line.
typedef struct CommandMistake
{
    const char* options;
    int status;          ///< exit status that it gives
    const char* message; ///< a part of its standard error
} CommandMistake;

/// Runs the command with each mistake: its status and message, and nothing on standard output.
void CheckMistakes(const char* command, const CommandMistake* mistakes, size_t count);

void WriteText(const char* path, const char* text);
/// Reads a file into `text`, terminated by a zero. False: there is no such file.
bool ReadText(const char* path, char* text, size_t size);
/// The number of entries of the folder, without "." and "..".
size_t CountEntries(void);

#ifdef __cplusplus
}
#endif

#endif
