// Values of command-line options. One that is not understood ends the program with a message that names the option and
// what it may be, by argp_error.
#ifndef QC_DEMOS_COMMON_OPTION_VALUES_H
#define QC_DEMOS_COMMON_OPTION_VALUES_H

#include "quickcullide/quickcullide.h"

#include <argp.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A word and what it stands for; a null name ends a list.
typedef struct qcWord
{
    const char* name;
    int value;
} qcWord;

/// The kinds of devices.
extern const qcWord qcDeviceWords[];

int qcOption_ReadWord(const struct argp_state* state, const char* option, const char* text, const qcWord* words);
uint32_t qcOption_ReadNumber(const struct argp_state* state, const char* option, const char* text, uint32_t lowest,
                             uint32_t highest);
/// A finite number of 0 or more, in decimal.
double qcOption_ReadLength(const struct argp_state* state, const char* option, const char* text);
/// Receives a word of a list; the context is the parser's input.
typedef void qcTakeWord(const struct argp_state* state, const char* word, void* context);
/// Gives each word of "a,b,c" to a function; the text is taken apart.
void qcOption_ReadList(const struct argp_state* state, const char* option, char* text, qcTakeWord* take);
/// Any text but an empty one.
const char* qcOption_ReadFolder(const struct argp_state* state, const char* option, const char* text);
/// 1 to 3 different letters of x, y, z.
void qcOption_ReadViews(const struct argp_state* state, const char* option, const char* text, char views[4]);

#ifdef __cplusplus
}
#endif

#endif
