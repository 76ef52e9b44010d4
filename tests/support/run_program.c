// Runs programs in a folder of their own.
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE 700
#include "support/run_program.h"

#include <check.h>
#include <dirent.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static char s_output[1 << 18];
static char s_errors[1 << 18];

static char s_folder[512];

const char* GetOutput(void)
{
    return s_output;
}

const char* GetErrors(void)
{
    return s_errors;
}

void EnterFolder(void)
{
    const char* parent = getenv("TMPDIR");
    snprintf(s_folder, sizeof s_folder, "%s/qc_test.XXXXXX", parent != NULL ? parent : P_tmpdir);
    ck_assert_ptr_nonnull(mkdtemp(s_folder));
    ck_assert_int_eq(chdir(s_folder), 0);
}

void LeaveFolder(void)
{
    char command[sizeof s_folder + 16];
    snprintf(command, sizeof command, "rm -r '%s'", s_folder);
    ck_assert_int_eq(chdir("/"), 0);
    ck_assert_int_eq(system(command), 0);
}

int Run(const char* format, ...)
{
    char command[4096];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(command, sizeof command, format, arguments);
    va_end(arguments);
    static const char redirection[] = " >.stdout 2>.stderr";
    ck_assert_uint_lt((size_t)length + sizeof redirection, sizeof command);
    // Before the command's own redirections, which take precedence.
    char whole[sizeof command + sizeof redirection + 8];
    snprintf(whole, sizeof whole, "exec%s; %s", redirection, command);
    int status = system(whole);
    ck_assert(ReadText(".stdout", s_output, sizeof s_output));
    ck_assert(ReadText(".stderr", s_errors, sizeof s_errors));
    remove(".stdout");
    remove(".stderr");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void CheckMistakes(const char* command, const CommandMistake* mistakes, size_t count)
{
    for (size_t i = 0; i < count; ++i)
    {
        int status = Run("%s %s", command, mistakes[i].options);
        ck_assert_msg(status == mistakes[i].status, "%s: %d", mistakes[i].options, status);
        ck_assert_msg(strstr(GetErrors(), mistakes[i].message) != NULL, "%s: %s", mistakes[i].options, GetErrors());
        ck_assert_str_eq(GetOutput(), "");
    }
}

void WriteText(const char* path, const char* text)
{
    FILE* stream = fopen(path, "w");
    ck_assert_ptr_nonnull(stream);
    ck_assert_int_ge(fputs(text, stream), 0);
    ck_assert_int_eq(fclose(stream), 0);
}

bool ReadText(const char* path, char* text, size_t size)
{
    FILE* stream = fopen(path, "r");
    if (stream == NULL)
        return false;
    size_t length = fread(text, 1, size - 1, stream);
    ck_assert_uint_lt(length, size - 1);
    text[length] = 0;
    fclose(stream);
    return true;
}

size_t CountEntries(void)
{
    DIR* folder = opendir(".");
    ck_assert_ptr_nonnull(folder);
    size_t count = 0;
    for (const struct dirent* entry; (entry = readdir(folder)) != NULL;)
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(folder);
    return count;
}
