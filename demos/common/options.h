// A command line as a table: each row has an option, its variable and the allowed values. A mistake ends the program
// with qc_exitUsage and a message that names the option.
//
//     const qcOption rows[] = {
//         {1, "steps", "N", "Steps of the simulation; %s by default", qcOption_Number(&steps, 1, 99)},
//         {0},
//     };
#ifndef QC_DEMOS_COMMON_OPTIONS_H
#define QC_DEMOS_COMMON_OPTIONS_H

#include "quickcullide/quickcullide.h"

#include <argp.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A word and its value; a null name ends a list.
typedef struct qcWord
{
    const char* name;
    int value;
} qcWord;

/// The kinds of devices.
extern const qcWord qcDeviceWords[];

/// Reads an option's text in a format of its own; rejects it by argp_error.
typedef void qcTakeText(const struct argp_state* state, const char* text, void* context);

typedef enum qcOptionKind
{
    qc_optionFlag,
    qc_optionNumber,
    qc_optionLength,
    qc_optionText,
    qc_optionFolder,
    qc_optionMethod,
    qc_optionDevice,
    qc_optionViews,
    qc_optionNumbers,
    qc_optionMarks,
    qc_optionTexts
} qcOptionKind;

/// Made by the functions below.
typedef struct qcOptionValue
{
    qcOptionKind kind;
    void* target;
    uint32_t lowest, highest;
    uint32_t *count, capacity; ///< of a list
    bool distinct;
    const qcWord* words;
    qcTakeText* take;
} qcOptionValue;

/// A row; one of zeros ends the table.
typedef struct qcOption
{
    int group;            ///< of --help, which sorts by it
    const char* name;     ///< null: a heading of the group
    const char* argument; ///< null: a flag
    const char* help;     ///< "%s" stands for the default: the target's value before parsing
    qcOptionValue value;
} qcOption;

/// Sets the target to `value`.
qcOptionValue qcOption_Flag(bool* target, bool value);
/// A whole number.
qcOptionValue qcOption_Number(uint32_t* target, uint32_t lowest, uint32_t highest);
/// A finite number of 0 or more, in decimal.
qcOptionValue qcOption_Length(double* target);
qcOptionValue qcOption_Text(const char** target);
/// Any text but an empty one.
qcOptionValue qcOption_Folder(const char** target);
qcOptionValue qcOption_Method(qcMethod* target, const qcWord* words);
qcOptionValue qcOption_Device(qcDeviceKind* target);
/// 1 to 3 different letters of x, y, z.
qcOptionValue qcOption_Views(char (*target)[4]);
/// "1,2,5", in place of a default list.
qcOptionValue qcOption_Numbers(uint32_t* targets, uint32_t* count, uint32_t capacity, uint32_t lowest, uint32_t highest,
                               bool distinct);
/// "a,b,c": sets the flag at each word's value; a negative value sets all. If none is named, all are set. All: the
/// first `count`; a word with a larger value has to be named.
qcOptionValue qcOption_Marks(bool* targets, uint32_t count, const qcWord* words);
/// "a,b,c": each word goes to `take`, with `context`.
qcOptionValue qcOption_Texts(qcTakeText* take, void* context);

typedef struct qcCommandLine
{
    const qcOption* options;
    const char* help;      ///< text before the options, "\v", text behind them
    const char* arguments; ///< "MESH...": one or more, in `paths`; null: none are allowed
    char** paths;
    uint32_t pathCount;
    /// Checks the options together and completes them, at the end; or null.
    void (*complete)(const struct argp_state* state, void* context);
    void* context;
} qcCommandLine;

/// What all programs have in common: --version, messages that begin with the program's name, and an end with
/// qc_exitFailed and a message where standard output could not be written. qcCommandLine_Parse calls it.
void qcCommandLine_Begin(char** arguments);
/// Ends the program after --help, after --version and on a mistake.
void qcCommandLine_Parse(qcCommandLine* commandLine, int argumentCount, char** arguments);

/// Ends the program if `output` (null: there is none), the file that `option` ("--out") names, is one of the files that
/// are read.
void qcCommandLine_KeepFiles(const qcCommandLine* commandLine, const char* program, const char* option,
                             const char* output);

/// The readers, for a qcTakeText. `option` ("--views") is named in messages.
uint32_t qcOption_ReadNumber(const struct argp_state* state, const char* option, const char* text, uint32_t lowest,
                             uint32_t highest);
int qcOption_ReadWord(const struct argp_state* state, const char* option, const char* text, const qcWord* words);
void qcOption_ReadViews(const struct argp_state* state, const char* option, const char* text, char views[4]);

#ifdef __cplusplus
}
#endif

#endif
