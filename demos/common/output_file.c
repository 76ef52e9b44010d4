// A file that appears under its name only when it is complete: a temporary file beside it, then rename.
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE 700
#include "common/output_file.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum
{
    // A table for the signal handler, which must not walk a list that is changing. No program writes more files at
    // once.
    qc_maxOpen = 8,
    // The limit of Linux.
    qc_maxLinks = 40
};

static char* volatile s_temporaries[qc_maxOpen];

static const int s_signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};

static void RemoveTemporaries(int signalNumber)
{
    for (int i = 0; i < qc_maxOpen; ++i)
    {
        if (s_temporaries[i] != NULL)
            unlink(s_temporaries[i]);
    }
    // SA_RESETHAND: this time the signal does what it does by default.
    raise(signalNumber);
}

static void WatchSignals(void)
{
    for (size_t i = 0; i < sizeof s_signals / sizeof s_signals[0]; ++i)
    {
        struct sigaction old;
        // A handler of the program stays, and so does SIG_IGN, which nohup sets.
        if (sigaction(s_signals[i], NULL, &old) != 0 || old.sa_handler != SIG_DFL)
            continue;
        struct sigaction action = {.sa_handler = RemoveTemporaries, .sa_flags = (int)SA_RESETHAND};
        sigemptyset(&action.sa_mask);
        sigaction(s_signals[i], &action, NULL);
    }
}

static void Replace(char* from, char* to)
{
    for (int i = 0; i < qc_maxOpen; ++i)
    {
        if (s_temporaries[i] == from)
        {
            s_temporaries[i] = to;
            return;
        }
    }
}

static bool Fail(const char* path, qcMessage* message)
{
    return qcMessage_Fail(message, "%s: %s", path, strerror(errno));
}

/// Ends the file; the temporary one is removed unless it got its name.
static void Close(qcOutput* output)
{
    if (output->stream != NULL)
        fclose(output->stream);
    if (output->temporary != NULL)
    {
        unlink(output->temporary);
        Replace(output->temporary, NULL);
    }
    free(output->temporary);
    free(output->path);
    *output = (qcOutput){0};
}

static bool OpenTemporary(qcOutput* output, mode_t mode)
{
    static const char ending[] = ".XXXXXX";
    size_t length = strlen(output->path);
    output->temporary = malloc(length + sizeof ending);
    if (output->temporary == NULL)
        return false;
    memcpy(output->temporary, output->path, length);
    memcpy(output->temporary + length, ending, sizeof ending);
    int descriptor = mkstemp(output->temporary);
    if (descriptor < 0)
    {
        free(output->temporary);
        output->temporary = NULL;
        return false;
    }
    Replace(NULL, output->temporary);
    WatchSignals();
    // mkstemp lets nobody else read; the finished file is an ordinary one.
    bool opened = fchmod(descriptor, mode) == 0 && (output->stream = fdopen(descriptor, "wb")) != NULL;
    if (!opened)
        close(descriptor);
    return opened;
}

/// The target of a symbolic link, relative to the link's folder if it is relative. Null with errno: the path is no
/// link.
static char* ReadLink(const char* path)
{
    char target[PATH_MAX];
    ssize_t length = readlink(path, target, sizeof target);
    if (length < 0)
        return NULL;
    if (length == (ssize_t)sizeof target)
    {
        errno = ENAMETOOLONG;
        return NULL;
    }
    const char* slash = target[0] == '/' ? NULL : strrchr(path, '/');
    size_t folder = slash != NULL ? (size_t)(slash - path) + 1 : 0;
    char* joined = malloc(folder + (size_t)length + 1);
    if (joined == NULL)
        return NULL;
    memcpy(joined, path, folder);
    memcpy(joined + folder, target, (size_t)length);
    joined[folder + (size_t)length] = 0;
    return joined;
}

/// The path of a file to be created: the end of the chain of symbolic links, if the path is one. Null: see errno.
static char* FollowLinks(const char* path)
{
    char* at = strdup(path);
    for (int i = 0; at != NULL && i < qc_maxLinks; ++i)
    {
        char* next = ReadLink(at);
        // Nothing is there, or no link.
        if (next == NULL && (errno == ENOENT || errno == EINVAL))
            return at;
        free(at);
        at = next;
    }
    if (at != NULL)
        errno = ELOOP;
    free(at);
    return NULL;
}

bool qcOutput_Open(const char* path, qcOutput* output, qcMessage* message)
{
    *output = (qcOutput){0};
    struct stat status;
    bool exists = stat(path, &status) == 0;
    if (!exists && errno != ENOENT)
        return Fail(path, message);
    bool isDirect = exists && !S_ISREG(status.st_mode);
    // The file behind a symbolic link is replaced, not the link. A link to a pipe, as in /dev/fd, has no path.
    output->path = isDirect ? strdup(path) : exists ? realpath(path, NULL) : FollowLinks(path);
    if (output->path == NULL)
        return Fail(path, message);
    bool opened;
    if (isDirect)
    {
        output->stream = fopen(path, "wb");
        opened = output->stream != NULL;
    }
    else
    {
        mode_t mask = umask(0);
        umask(mask);
        opened = OpenTemporary(output, exists ? status.st_mode & 0777 : 0666 & ~mask);
    }
    if (!opened)
    {
        Fail(path, message);
        Close(output);
    }
    return opened;
}

bool qcOutput_Commit(qcOutput* output, qcMessage* message)
{
    errno = 0;
    bool written = ferror(output->stream) == 0;
    // A file system may report a full disk as late as here.
    written = fflush(output->stream) == 0 && written;
    written = fclose(output->stream) == 0 && written;
    output->stream = NULL;
    if (written && output->temporary != NULL)
    {
        written = rename(output->temporary, output->path) == 0;
        if (written)
        {
            Replace(output->temporary, NULL);
            free(output->temporary);
            output->temporary = NULL;
        }
    }
    if (!written)
        qcMessage_Fail(message, "%s: %s", output->path, errno != 0 ? strerror(errno) : "not written");
    Close(output);
    return written;
}

bool qcOutput_IsSame(const char* path, const char* other)
{
    struct stat a, b;
    if (stat(path, &a) == 0 && stat(other, &b) == 0)
        return S_ISREG(a.st_mode) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
    // What is not there yet: by its folder and its name.
    char* ends[2] = {FollowLinks(path), FollowLinks(other)};
    bool isSame = ends[0] != NULL && ends[1] != NULL;
    const char* names[2] = {"", ""};
    for (int i = 0; i < 2 && isSame; ++i)
    {
        char* slash = strrchr(ends[i], '/');
        names[i] = slash != NULL ? slash + 1 : ends[i];
    }
    struct stat folders[2];
    isSame = isSame && strcmp(names[0], names[1]) == 0;
    for (int i = 0; i < 2 && isSame; ++i)
    {
        char* folder = strndup(ends[i], (size_t)(names[i] - ends[i]));
        isSame = folder != NULL && stat(folder[0] != 0 ? folder : ".", &folders[i]) == 0;
        free(folder);
    }
    isSame = isSame && folders[0].st_dev == folders[1].st_dev && folders[0].st_ino == folders[1].st_ino;
    free(ends[0]);
    free(ends[1]);
    return isSame;
}

void qcOutput_Abort(qcOutput* output)
{
    Close(output);
}

bool qcOutput_Check(const char* path, qcMessage* message)
{
    struct stat status;
    // Opening a pipe only to try it would end it for its reader.
    if (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
        return true;
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    qcOutput_Abort(&output);
    return true;
}
