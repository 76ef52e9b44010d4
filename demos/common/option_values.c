// Values of command-line options, read strictly.
#define _POSIX_C_SOURCE 200809L
#include "common/option_values.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const qcWord qcDeviceWords[] = {{"auto", qc_deviceAuto},     {"egl", qc_deviceEgl},
                                {"osmesa", qc_deviceOsmesa}, {"surfaceless", qc_deviceSurfaceless},
                                {"none", qc_deviceNone},     {NULL, 0}};

int qcOption_ReadWord(const struct argp_state* state, const char* option, const char* text, const qcWord* words)
{
    char allowed[128] = "";
    for (const qcWord* word = words; word->name != NULL; ++word)
    {
        if (strcmp(word->name, text) == 0)
            return word->value;
        strcat(strcat(allowed, word == words ? "" : ", "), word->name);
    }
    argp_error(state, "%s: '%s' is not one of %s", option, text, allowed);
    return 0;
}

uint32_t qcOption_ReadNumber(const struct argp_state* state, const char* option, const char* text, uint32_t lowest,
                             uint32_t highest)
{
    char* end;
    errno = 0;
    unsigned long value = strtoul(text, &end, 10);
    // strtoul takes "-1" and " 1" too.
    if (text[0] < '0' || text[0] > '9' || *end != 0 || errno != 0 || value < lowest || value > highest)
        argp_error(state, "%s: '%s' is not a whole number in %u..%u", option, text, lowest, highest);
    return (uint32_t)value;
}

double qcOption_ReadLength(const struct argp_state* state, const char* option, const char* text)
{
    char* end;
    double value = strtod(text, &end);
    // strtod takes " 1", "nan" and "0x1" too.
    if (strspn(text, "0123456789.eE+-") != strlen(text) || end == text || *end != 0 || !(value >= 0.0) || isinf(value))
        argp_error(state, "%s: '%s' is not a number of 0 or more", option, text);
    return value;
}

void qcOption_ReadList(const struct argp_state* state, const char* option, char* text, qcTakeWord* take)
{
    if (*text == 0 || *text == ',' || text[strlen(text) - 1] == ',' || strstr(text, ",,") != NULL)
        argp_error(state, "%s: '%s' is not a list such as a,b,c", option, text);
    char* rest = NULL;
    for (char* word = strtok_r(text, ",", &rest); word != NULL; word = strtok_r(NULL, ",", &rest))
        take(state, word, state->input);
}

const char* qcOption_ReadFolder(const struct argp_state* state, const char* option, const char* text)
{
    if (*text == 0)
        argp_error(state, "%s: no folder is named", option);
    return text;
}

void qcOption_ReadViews(const struct argp_state* state, const char* option, const char* text, char views[4])
{
    size_t length = strlen(text);
    bool valid = length >= 1 && length <= 3 && strspn(text, "xyz") == length;
    for (size_t i = 0; valid && i < length; ++i)
        valid = strchr(text + i + 1, text[i]) == NULL;
    if (!valid)
        argp_error(state, "%s: '%s' is not 1 to 3 different letters of x, y and z", option, text);
    memset(views, 0, 4);
    memcpy(views, text, length);
}
