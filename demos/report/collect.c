// Which files belong to which part of the report.
#define _GNU_SOURCE
#include "report/report.h"

#include "parts_script.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

enum
{
    qc_digitsOfSeries = 3, ///< "_012.png": with fewer digits it is a picture by itself
    qc_picturesOfSeries = 3
};

/// Folders with results that are no part by themselves.
static bool IsApart(const char* folder)
{
    return strcmp(folder, "bench") == 0 || strcmp(folder, "report") == 0 || folder[0] == '.';
}

static qcReportKind FindKind(const char* name)
{
    static const struct
    {
        const char* ending;
        qcReportKind kind;
    } kinds[] = {{".mp4", qc_reportFilm},    {".webm", qc_reportFilm},   {".svg", qc_reportPicture},
                 {".png", qc_reportPicture}, {".jpg", qc_reportPicture}, {".txt", qc_reportText},
                 {".csv", qc_reportTable}};
    const char* ending = strrchr(name, '.');
    for (size_t i = 0; ending != NULL && i < sizeof kinds / sizeof kinds[0]; ++i)
    {
        if (strcasecmp(ending, kinds[i].ending) == 0)
            return kinds[i].kind;
    }
    return qc_reportOther;
}

/// Adds a part; null: out of memory.
static qcReportPart* AddPart(qcReport* report, const char* name, size_t nameLength, char* command, char* title)
{
    qcReportPart* parts = realloc(report->parts, (report->partCount + 1) * sizeof *parts);
    if (parts == NULL)
        return NULL;
    report->parts = parts;
    qcReportPart* part = &parts[report->partCount];
    *part = (qcReportPart){.name = strndup(name, nameLength), .command = command, .title = title};
    if (part->name == NULL)
        return NULL;
    ++report->partCount;
    return part;
}

/// Lines "name|arguments|options|title".
static bool AddKnownParts(qcReport* report)
{
    for (const char* line = s_partsScript; *line != 0;)
    {
        const char* end = strchrnul(line, '\n');
        const char* bars[3] = {NULL};
        size_t count = 0;
        for (const char* c = line; c < end && count < 3; ++c)
        {
            if (*c == '|')
                bars[count++] = c;
        }
        if (*line != '#' && count == 3)
        {
            char* command = strndup(bars[0] + 1, (size_t)(bars[1] - bars[0] - 1));
            char* title = strndup(bars[2] + 1, (size_t)(end - bars[2] - 1));
            if (command == NULL || title == NULL || !AddPart(report, line, (size_t)(bars[0] - line), command, title))
                return false;
        }
        line = *end == 0 ? end : end + 1;
    }
    return true;
}

/// What the names of a part's files in FOLDER/bench, or of its own folder, begin with; null: it has none there.
static const char* FindPrefix(const qcReportPart* part, bool isInBench)
{
    static const char bench[] = "bench ";
    if (part->command == NULL)
        return part->name;
    bool isBenchmark = strncmp(part->command, bench, sizeof bench - 1) == 0;
    if (isBenchmark != isInBench)
        return NULL;
    return isBenchmark ? part->command + sizeof bench - 1 : part->name;
}

/// The part of a file of FOLDER/bench, or of a folder, the one with the longest fitting prefix; null: none yet.
static qcReportPart* FindPart(qcReport* report, const char* name, bool isInBench)
{
    qcReportPart* found = NULL;
    size_t longest = 0;
    for (size_t i = 0; i < report->partCount; ++i)
    {
        const char* prefix = FindPrefix(&report->parts[i], isInBench);
        size_t length = prefix != NULL ? strlen(prefix) : 0;
        if (length > longest && strncmp(name, prefix, length) == 0 && !isalnum((unsigned char)name[length]))
        {
            found = &report->parts[i];
            longest = length;
        }
    }
    return found;
}

static bool AddFile(qcReportPart* part, const char* folder, const char* name)
{
    qcReportFile file = {.kind = FindKind(name)};
    if (file.kind == qc_reportOther)
        return true;
    struct stat status;
    qcReportFile* files = realloc(part->files, (part->fileCount + 1) * sizeof *files);
    if (files == NULL)
        return false;
    part->files = files;
    if (asprintf(&file.path, "%s/%s", folder, name) < 0)
        return false;
    if (stat(file.path, &status) != 0 || !S_ISREG(status.st_mode))
    {
        free(file.path);
        return true;
    }
    file.name = file.path + strlen(folder) + 1;
    file.time = status.st_mtime;
    files[part->fileCount++] = file;
    return true;
}

/// Adds the files of a folder to a part; to the parts whose name they begin with if `part` is null.
static bool AddFolder(qcReport* report, const char* folder, const char* partName)
{
    struct dirent** entries = NULL;
    int count = scandir(folder, &entries, NULL, alphasort);
    bool isAdded = true;
    for (int i = 0; i < count; ++i)
    {
        const char* name = entries[i]->d_name;
        if (isAdded && FindKind(name) != qc_reportOther && name[0] != '.')
        {
            qcReportPart* part = FindPart(report, partName != NULL ? partName : name, partName == NULL);
            const char* newName = partName != NULL ? partName : name;
            if (part == NULL)
                part = AddPart(report, newName, partName != NULL ? strlen(partName) : strcspn(name, "_."), NULL, NULL);
            isAdded = part != NULL && AddFile(part, folder, name);
        }
        free(entries[i]);
    }
    free(entries);
    return isAdded;
}

static bool AddAllFolders(qcReport* report, const char* folder)
{
    struct dirent** entries = NULL;
    int count = scandir(folder, &entries, NULL, alphasort);
    char* path = NULL;
    bool isAdded = asprintf(&path, "%s/bench", folder) >= 0 && AddFolder(report, path, NULL);
    free(path);
    for (int i = 0; i < count; ++i)
    {
        const char* name = entries[i]->d_name;
        if (isAdded && !IsApart(name))
        {
            isAdded = asprintf(&path, "%s/%s", folder, name) >= 0 && AddFolder(report, path, name);
            free(path);
        }
        free(entries[i]);
    }
    free(entries);
    return isAdded;
}

//  ---- choosing pictures ---------------------------------------------------------------------------

/// Length of the name of a numbered picture without its number and ending; 0: it has no number.
static size_t FindSeries(const char* name)
{
    size_t end = strcspn(name, ".");
    size_t begin = end;
    while (begin > 0 && isdigit((unsigned char)name[begin - 1]))
        --begin;
    return end - begin >= qc_digitsOfSeries ? begin : 0;
}

static size_t FindStem(const char* name)
{
    const char* ending = strrchr(name, '.');
    return ending != NULL ? (size_t)(ending - name) : strlen(name);
}

/// True if a newer or equally old SVG shows the same.
static bool IsReplaced(const qcReportPart* part, size_t index)
{
    const qcReportFile* file = &part->files[index];
    size_t stem = FindStem(file->name);
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        const qcReportFile* other = &part->files[i];
        if (i != index && strcmp(other->name + FindStem(other->name), ".svg") == 0 && FindStem(other->name) == stem &&
            strncmp(file->name, other->name, stem) == 0 && other->time >= file->time)
            return true;
    }
    return false;
}

/// True for the pictures of a series that are not shown. Files are sorted by name.
static bool IsSkipped(const qcReportPart* part, size_t index)
{
    const char* name = part->files[index].name;
    size_t length = FindSeries(name), count = 0, place = 0;
    if (length == 0)
        return false;
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        const char* other = part->files[i].name;
        if (part->files[i].kind != qc_reportPicture || FindSeries(other) != length || strncmp(other, name, length) != 0)
            continue;
        place = i == index ? count : place;
        ++count;
    }
    for (size_t shown = 1; shown <= qc_picturesOfSeries; ++shown)
    {
        if (place == shown * count / qc_picturesOfSeries - 1 || count <= qc_picturesOfSeries)
            return false;
    }
    return true;
}

static int CompareFiles(const void* a, const void* b)
{
    const qcReportFile *x = a, *y = b;
    return x->kind != y->kind ? (x->kind < y->kind ? -1 : 1) : strcmp(x->name, y->name);
}

static void ChoosePictures(qcReportPart* part)
{
    if (part->fileCount == 0)
        return;
    qsort(part->files, part->fileCount, sizeof *part->files, CompareFiles);
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        if (part->files[i].kind == qc_reportPicture && (IsReplaced(part, i) || IsSkipped(part, i)))
            part->files[i].time = 0;
    }
    size_t count = 0;
    for (size_t i = 0; i < part->fileCount; ++i)
    {
        if (part->files[i].time != 0)
            part->files[count++] = part->files[i];
        else
            free(part->files[i].path);
    }
    part->fileCount = count;
}

bool qcReport_Collect(const char* folder, qcReport* report, qcMessage* message)
{
    *report = (qcReport){NULL, 0};
    DIR* there = opendir(folder);
    if (there == NULL)
        return qcMessage_Fail(message, "%s: %s", folder, strerror(errno));
    closedir(there);
    if (!AddKnownParts(report) || !AddAllFolders(report, folder))
    {
        qcReport_Free(report);
        return qcMessage_Fail(message, "out of memory");
    }
    for (size_t i = 0; i < report->partCount; ++i)
        ChoosePictures(&report->parts[i]);
    return true;
}

void qcReport_Free(qcReport* report)
{
    for (size_t i = 0; i < report->partCount; ++i)
    {
        qcReportPart* part = &report->parts[i];
        for (size_t f = 0; f < part->fileCount; ++f)
            free(part->files[f].path);
        free(part->files);
        free(part->name);
        free(part->command);
        free(part->title);
    }
    free(report->parts);
    *report = (qcReport){NULL, 0};
}
