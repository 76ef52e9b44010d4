// Command lines as tables, on top of argp.
#define _GNU_SOURCE
#include "common/options.h"

#include "common/exit_status.h"
#include "common/output_file.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum
{
    // Beyond every character: no option has a short name.
    qc_firstKey = 256,
    qc_maxOptions = 32
};

const qcWord qcDeviceWords[] = {{"auto", qc_deviceAuto},     {"egl", qc_deviceEgl},
                                {"osmesa", qc_deviceOsmesa}, {"surfaceless", qc_deviceSurfaceless},
                                {"none", qc_deviceNone},     {NULL, 0}};

//  ---- kinds ---------------------------------------------------------------------------------------

qcOptionValue qcOption_Flag(bool* target, bool value)
{
    return (qcOptionValue){.kind = qc_optionFlag, .target = target, .highest = value};
}

qcOptionValue qcOption_Number(uint32_t* target, uint32_t lowest, uint32_t highest)
{
    return (qcOptionValue){.kind = qc_optionNumber, .target = target, .lowest = lowest, .highest = highest};
}

qcOptionValue qcOption_Length(double* target)
{
    return (qcOptionValue){.kind = qc_optionLength, .target = target};
}

qcOptionValue qcOption_Text(const char** target)
{
    return (qcOptionValue){.kind = qc_optionText, .target = target};
}

qcOptionValue qcOption_Folder(const char** target)
{
    return (qcOptionValue){.kind = qc_optionFolder, .target = target};
}

qcOptionValue qcOption_Method(qcMethod* target, const qcWord* words)
{
    return (qcOptionValue){.kind = qc_optionMethod, .target = target, .words = words};
}

qcOptionValue qcOption_Device(qcDeviceKind* target)
{
    return (qcOptionValue){.kind = qc_optionDevice, .target = target, .words = qcDeviceWords};
}

qcOptionValue qcOption_Views(char (*target)[4])
{
    return (qcOptionValue){.kind = qc_optionViews, .target = target};
}

qcOptionValue qcOption_Numbers(uint32_t* targets, uint32_t* count, uint32_t capacity, uint32_t lowest, uint32_t highest,
                               bool distinct)
{
    return (qcOptionValue){.kind = qc_optionNumbers,
                           .target = targets,
                           .lowest = lowest,
                           .highest = highest,
                           .count = count,
                           .capacity = capacity,
                           .distinct = distinct};
}

qcOptionValue qcOption_Marks(bool* targets, uint32_t count, const qcWord* words)
{
    return (qcOptionValue){.kind = qc_optionMarks, .target = targets, .capacity = count, .words = words};
}

qcOptionValue qcOption_Texts(qcTakeText* take, void* context)
{
    return (qcOptionValue){.kind = qc_optionTexts, .target = context, .take = take};
}

//  ---- readers -------------------------------------------------------------------------------------

int qcOption_ReadWord(const struct argp_state* state, const char* option, const char* text, const qcWord* words)
{
    char allowed[512] = "";
    for (const qcWord* word = words; word->name != NULL; ++word)
    {
        if (strcmp(word->name, text) == 0)
            return word->value;
        size_t length = strlen(allowed);
        snprintf(allowed + length, sizeof allowed - length, "%s%s", word == words ? "" : ", ", word->name);
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

static double ReadLength(const struct argp_state* state, const char* option, const char* text)
{
    char* end;
    double value = strtod(text, &end);
    // strtod takes " 1", "nan" and "0x1" too.
    if (strspn(text, "0123456789.eE+-") != strlen(text) || end == text || *end != 0 || !(value >= 0.0) || isinf(value))
        argp_error(state, "%s: '%s' is not a number of 0 or more", option, text);
    return value;
}

static void AppendNumber(const struct argp_state* state, const char* option, const char* word,
                         const qcOptionValue* list)
{
    uint32_t* numbers = list->target;
    uint32_t number = qcOption_ReadNumber(state, option, word, list->lowest, list->highest);
    for (uint32_t i = 0; list->distinct && i < *list->count; ++i)
    {
        if (numbers[i] == number)
            argp_error(state, "%s: '%s' is named twice", option, word);
    }
    if (*list->count == list->capacity)
        argp_error(state, "%s: more than %u of them", option, list->capacity);
    numbers[(*list->count)++] = number;
}

static void SetMark(const struct argp_state* state, const char* option, const char* word, const qcOptionValue* marks)
{
    bool* flags = marks->target;
    int index = qcOption_ReadWord(state, option, word, marks->words);
    if (index < 0)
        memset(flags, true, marks->capacity);
    else
        flags[index] = true;
}

static void ReadList(const struct argp_state* state, const char* option, char* text, const qcOptionValue* list)
{
    if (*text == 0 || *text == ',' || text[strlen(text) - 1] == ',' || strstr(text, ",,") != NULL)
        argp_error(state, "%s: '%s' is not a list such as a,b,c", option, text);
    char* rest = NULL;
    for (char* word = strtok_r(text, ",", &rest); word != NULL; word = strtok_r(NULL, ",", &rest))
    {
        if (list->kind == qc_optionNumbers)
            AppendNumber(state, option, word, list);
        else if (list->kind == qc_optionMarks)
            SetMark(state, option, word, list);
        else
            list->take(state, word, list->target);
    }
}

static void ReadValue(const struct argp_state* state, const qcOption* row, char* text)
{
    const qcOptionValue* value = &row->value;
    char option[64];
    snprintf(option, sizeof option, "--%s", row->name);
    switch (value->kind)
    {
        case qc_optionFlag: *(bool*)value->target = value->highest != 0; break;
        case qc_optionNumber:
            *(uint32_t*)value->target = qcOption_ReadNumber(state, option, text, value->lowest, value->highest);
            break;
        case qc_optionLength: *(double*)value->target = ReadLength(state, option, text); break;
        case qc_optionFolder:
            if (*text == 0)
                argp_error(state, "%s: no folder is named", option);
            *(const char**)value->target = text;
            break;
        case qc_optionText: *(const char**)value->target = text; break;
        case qc_optionMethod:
            *(qcMethod*)value->target = (qcMethod)qcOption_ReadWord(state, option, text, value->words);
            break;
        case qc_optionDevice:
            *(qcDeviceKind*)value->target = (qcDeviceKind)qcOption_ReadWord(state, option, text, value->words);
            break;
        case qc_optionViews: qcOption_ReadViews(state, option, text, *(char(*)[4])value->target); break;
        case qc_optionNumbers:
        case qc_optionMarks:
        case qc_optionTexts: ReadList(state, option, text, value); break;
    }
}

//  ---- argp ----------------------------------------------------------------------------------------

typedef struct Parse
{
    qcCommandLine* line;
    bool given[qc_maxOptions];
} Parse;

static uint32_t CountRows(const qcOption* rows)
{
    uint32_t count = 0;
    while (rows[count].name != NULL || rows[count].help != NULL)
        ++count;
    return count;
}

/// Marks "all" of each list that is not given.
static void CompleteMarks(const Parse* parse)
{
    for (uint32_t i = 0; i < CountRows(parse->line->options); ++i)
    {
        const qcOptionValue* value = &parse->line->options[i].value;
        if (value->kind == qc_optionMarks && !parse->given[i])
            memset(value->target, true, value->capacity);
    }
}

static void RefuseArgument(const struct argp_state* state, const qcOption* rows, const char* text)
{
    bool hasScenes = false;
    for (; rows->name != NULL || rows->help != NULL; ++rows)
        hasScenes = hasScenes || (rows->name != NULL && strcmp(rows->name, "scenes") == 0);
    argp_error(state, "'%s': options only, please%s", text, hasScenes ? "; scenes follow --scenes" : "");
}

/// The first list that is given replaces the default.
static void EmptyList(Parse* parse, int row)
{
    const qcOptionValue* value = &parse->line->options[row].value;
    if (value->kind == qc_optionNumbers && !parse->given[row])
        *value->count = 0;
    parse->given[row] = true;
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    Parse* parse = state->input;
    qcCommandLine* line = parse->line;
    if (key >= qc_firstKey && key < qc_firstKey + qc_maxOptions)
    {
        EmptyList(parse, key - qc_firstKey);
        ReadValue(state, &line->options[key - qc_firstKey], text);
        return 0;
    }
    switch (key)
    {
        case ARGP_KEY_ARGS:
            if (line->arguments == NULL)
                RefuseArgument(state, line->options, state->argv[state->next]);
            line->paths = state->argv + state->next;
            line->pathCount = (uint32_t)(state->argc - state->next);
            return 0;
        case ARGP_KEY_NO_ARGS:
            if (line->arguments != NULL)
                argp_error(state, "no %.*s is named", (int)strcspn(line->arguments, "."), line->arguments);
            return 0;
        case ARGP_KEY_END:
            CompleteMarks(parse);
            if (line->complete != NULL)
                line->complete(state, line->context);
            return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

/// Replaces "%s" by the default; argp frees the text.
static char* WriteDefault(int key, const char* text, void* input)
{
    const Parse* parse = input;
    const char* mark = text != NULL ? strstr(text, "%s") : NULL;
    if (parse == NULL || mark == NULL || key < qc_firstKey || key >= qc_firstKey + qc_maxOptions)
        return (char*)text;
    const qcOptionValue* value = &parse->line->options[key - qc_firstKey].value;
    char numbers[256] = "";
    const char* shown = numbers;
    if (value->kind == qc_optionText || value->kind == qc_optionFolder)
        shown = *(const char**)value->target;
    else if (value->kind == qc_optionMethod)
        shown = qcMethod_Name(*(qcMethod*)value->target);
    else
    {
        uint32_t count = value->kind == qc_optionNumbers ? *value->count : 1;
        for (uint32_t i = 0; i < count; ++i)
        {
            size_t length = strlen(numbers);
            snprintf(numbers + length, sizeof numbers - length, "%s%u", i == 0 ? "" : ",",
                     ((uint32_t*)value->target)[i]);
        }
    }
    char* filled;
    int length = asprintf(&filled, "%.*s%s%s", (int)(mark - text), text, shown, mark + 2);
    return length < 0 ? (char*)text : filled;
}

/// The version is that of the library that is loaded.
static void PrintVersion(FILE* stream, struct argp_state* state)
{
    const uint32_t version = qcVersion();
    fprintf(stream, "%s %u.%u.%u\n", state->name, version / 10000, version / 100 % 100, version % 100);
}

static void CheckStandardOutput(int status, void* unused)
{
    (void)unused;
    errno = 0;
    if (fflush(stdout) == 0 && ferror(stdout) == 0)
        return;
    fprintf(stderr, "%s: standard output: %s\n", program_invocation_short_name,
            errno != 0 ? strerror(errno) : "not all of it could be written");
    if (status == qc_exitDone)
        _exit(qc_exitFailed);
}

void qcCommandLine_Begin(char** arguments)
{
    // getopt's messages begin with it.
    char* slash = strrchr(arguments[0], '/');
    if (slash != NULL)
        arguments[0] = slash + 1;
    argp_err_exit_status = qc_exitUsage;
    argp_program_version_hook = PrintVersion;
    static bool s_isChecked = false;
    if (!s_isChecked)
        on_exit(CheckStandardOutput, NULL);
    s_isChecked = true;
}

void qcCommandLine_Parse(qcCommandLine* commandLine, int argumentCount, char** arguments)
{
    struct argp_option options[qc_maxOptions + 1] = {{0}};
    uint32_t count = CountRows(commandLine->options);
    if (count > qc_maxOptions)
        abort();
    for (uint32_t i = 0; i < count; ++i)
    {
        const qcOption* row = &commandLine->options[i];
        options[i] = (struct argp_option){.name = row->name,
                                          .key = row->name != NULL ? (int)(qc_firstKey + i) : 0,
                                          .arg = row->argument,
                                          .doc = row->help,
                                          .group = row->group};
    }
    struct argp parser = {options, ReadOption, commandLine->arguments, commandLine->help, NULL, WriteDefault, NULL};
    qcCommandLine_Begin(arguments);
    Parse parse = {.line = commandLine};
    argp_parse(&parser, argumentCount, arguments, 0, NULL, &parse);
}

void qcCommandLine_KeepFiles(const qcCommandLine* commandLine, const char* program, const char* option,
                             const char* output)
{
    for (uint32_t i = 0; output != NULL && i < commandLine->pathCount; ++i)
        if (qcOutput_IsSame(output, commandLine->paths[i]))
        {
            fprintf(stderr, "%s: %s: '%s' would replace '%s', which is read; see --help\n", program, option, output,
                    commandLine->paths[i]);
            exit(qc_exitUsage);
        }
}
