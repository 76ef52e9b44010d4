// Output folders, fields of CSVs, and gnuplot.
#define _POSIX_C_SOURCE 200809L
#include "common/files.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum
{
    qc_notFound = 127 // the exit status of a shell
};

/// True if the folder is there now; otherwise see errno.
static bool MakeOne(const char* folder)
{
    if (mkdir(folder, 0777) == 0)
        return true;
    struct stat status;
    if (errno != EEXIST || stat(folder, &status) != 0)
        return false;
    errno = ENOTDIR;
    return S_ISDIR(status.st_mode);
}

bool qcFiles_MakeFolder(const char* path, qcMessage* message)
{
    char* part = strdup(path);
    if (part == NULL)
        return qcMessage_Fail(message, "out of memory");
    bool made = true;
    for (char* end = part + 1; made; ++end)
    {
        if (*end != '/' && *end != 0)
            continue;
        char rest = *end;
        *end = 0;
        made = MakeOne(part) || qcMessage_Fail(message, "%s: %s", part, strerror(errno));
        *end = rest;
        if (rest == 0)
            break;
    }
    free(part);
    return made;
}

bool qcFiles_IsThere(const char* path)
{
    FILE* stream = fopen(path, "rb");
    if (stream != NULL)
        fclose(stream);
    return stream != NULL || errno != ENOENT;
}

bool qcFiles_Check(const char* folder, const char* name, qcMessage* message)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return qcFiles_MakeFolder(folder, message) && qcOutput_Check(path, message);
}

bool qcFiles_Open(const char* folder, const char* name, qcOutput* output, qcMessage* message)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return qcOutput_Open(path, output, message);
}

void qcFiles_WriteQuoted(FILE* stream, const char* text)
{
    fputc('"', stream);
    for (; *text != 0; ++text)
    {
        if (*text == '"')
            fputc('"', stream);
        fputc(*text == '\n' ? ' ' : *text, stream);
    }
    fputc('"', stream);
}

/// gnuplot's exit status, qc_notFound where there is none, or -1.
static int RunGnuplot(const char* folder, const char* script)
{
    // The child would otherwise write buffered output a second time.
    fflush(stdout);
    pid_t child = fork();
    if (child < 0)
        return -1;
    if (child == 0)
    {
        if (chdir(folder) == 0)
            execlp("gnuplot", "gnuplot", script, (char*)NULL);
        _exit(errno == ENOENT ? qc_notFound : 126);
    }
    int status;
    while (waitpid(child, &status, 0) < 0)
    {
        if (errno != EINTR)
            return -1;
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool qcFiles_Draw(const char* folder, const char* script, qcMessage* message)
{
    int status = RunGnuplot(folder, script);
    if (status == qc_notFound)
    {
        fprintf(stderr, "gnuplot is not installed: no pictures; \"gnuplot %s\" in %s draws them\n", script, folder);
        return true;
    }
    return status == 0 || qcMessage_Fail(message, "gnuplot could not draw %s/%s", folder, script);
}
