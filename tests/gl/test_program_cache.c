// Binaries of programs: a second start compiles nothing, and no state of the cache's folder changes a result.
#define _DEFAULT_SOURCE // setenv, mkfifo, setrlimit
#include "gl/replaced_driver.h"
#include "support/run_program.h"
#include "support/suite.h"
#include "support/write_bytes.h"

#include <dirent.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum
{
    qc_maxFiles = 16,
    qc_maxFileSize = 1 << 22
};

//  ---- a start -----------------------------------------------------------------------------------------------------

static int s_compiled; // shaders, since the start

static void APIENTRY CountCompile(GLuint shader)
{
    s_compiled++;
    s_real.CompileShader(shader);
}

static void CountAll(struct qcGlFunctions* gl)
{
    gl->CompileShader = CountCompile;
}

/// Opens the device again and finds pairs with `layers`. Returns the number of shaders that were compiled.
static int StartWith(qcDevice* device, qcReplace* replace)
{
    CHECK_OK(qcDevice_Reopen(device));
    s_compiled = 0;
    ck_assert(MakeDriver(device, replace));
    World world = MakeWorld(device);
    const char* fallback = CheckPairs(world.scene, 0.0);
    ck_assert_msg(fallback == NULL, "%s", fallback);
    qcScene_Destroy(world.scene);
    return s_compiled;
}

static int Start(qcDevice* device)
{
    return StartWith(device, CountAll);
}

static qcStatus ReadFormatCount(const struct qcGlFunctions* gl, void* context)
{
    gl->GetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, context);
    return qc_statusOk;
}

/// Prints loudly where a driver has no binaries.
static bool HasBinaries(qcDevice* device)
{
    GLint count = 0;
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    CHECK_OK(qcDevice_Run(device, ReadFormatCount, &count, "a test"));
    printf("%s (%s): %d formats of program binaries%s\n", info.name, info.renderer, count,
           count > 0 ? "" : ": NOTHING TO LOAD, SKIPPED");
    fflush(stdout);
    return count > 0;
}

/// An empty folder, in which devices make their cache from now on.
static void EnterCache(void)
{
    char folder[512];
    EnterFolder();
    ck_assert_ptr_nonnull(getcwd(folder, sizeof folder - 16));
    strcat(folder, "/a/cache");
    ck_assert_int_eq(setenv("QC_PROGRAM_CACHE", folder, 1), 0);
}

//  ---- files -------------------------------------------------------------------------------------------------------

typedef struct Files
{
    char names[qc_maxFiles][320];
    int count;
} Files;

static Files ListFiles(void)
{
    Files files = {.count = 0};
    DIR* folder = opendir("a/cache");
    for (struct dirent* entry = NULL; folder != NULL && (entry = readdir(folder)) != NULL;)
    {
        if (entry->d_name[0] == '.')
            continue;
        ck_assert_int_lt(files.count, qc_maxFiles);
        snprintf(files.names[files.count++], sizeof files.names[0], "a/cache/%s", entry->d_name);
    }
    if (folder != NULL)
        closedir(folder);
    return files;
}

static size_t ReadBytes(const char* path, char* data)
{
    FILE* file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    size_t size = fread(data, 1, qc_maxFileSize, file);
    fclose(file);
    return size;
}

/// Changes a file's content; returns its new size.
typedef size_t Damage(char* data, size_t size);

static void DamageAll(const Files* files, Damage* damage)
{
    static char s_data[qc_maxFileSize];
    for (int i = 0; i < files->count; i++)
    {
        size_t size = ReadBytes(files->names[i], s_data);
        WriteBytes(files->names[i], s_data, damage(s_data, size));
    }
}

static size_t MakeEmpty(char* data, size_t size)
{
    (void)data;
    (void)size;
    return 0;
}

static size_t CutHeader(char* data, size_t size)
{
    (void)data;
    (void)size;
    return 20;
}

static size_t CutLastByte(char* data, size_t size)
{
    (void)data;
    return size - 1;
}

static size_t AddByte(char* data, size_t size)
{
    data[size] = 1;
    return size + 1;
}

static size_t ChangeMagic(char* data, size_t size)
{
    data[0] ^= 1;
    return size;
}

static size_t ChangeChecksum(char* data, size_t size)
{
    data[8] ^= 1;
    return size;
}

static size_t ChangeSizes(char* data, size_t size)
{
    memset(data + 16, 0xff, 8);
    return size;
}

static size_t ChangeTag(char* data, size_t size)
{
    data[24] ^= 1;
    return size;
}

/// A text of the key: the name of the driver's vendor or what stands before it.
static size_t ChangeDriver(char* data, size_t size)
{
    data[35] ^= 1;
    return size;
}

static size_t ChangeBinary(char* data, size_t size)
{
    data[size - size / 8] ^= 1;
    return size;
}

static size_t FillWithNoise(char* data, size_t size)
{
    qcRandom random = {5};
    for (size_t i = 0; i < size; i++)
        data[i] = (char)qcRandom_Next(&random);
    return size;
}

//  ---- tests -------------------------------------------------------------------------------------------------------

START_TEST(a_second_start_compiles_nothing_and_finds_the_same_pairs)
{
    EnterCache();
    unsetenv("QC_LAYERS_REFINE");
    QC_FOR_EACH_DEVICE(device)
    {
        const bool hasBinaries = HasBinaries(device);
        int before = ListFiles().count, compiled = Start(device), stored = ListFiles().count - before;
        ck_assert_int_gt(compiled, 0);
        if (!hasBinaries)
        {
            ck_assert_int_eq(stored, 0);
            ck_assert_int_eq(Start(device), compiled);
            continue;
        }
        ck_assert_int_eq(stored, compiled); // compute programs have one shader each
        ck_assert_int_eq(Start(device), 0);
        ck_assert_int_eq(ListFiles().count - before, stored);
        // Refining on the device takes other kernels than software GL has compiled so far. A GPU refines there anyway.
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        setenv("QC_LAYERS_REFINE", "device", 1);
        int others = Start(device);
        ck_assert(info.software == (others > 0));
        ck_assert_int_eq(Start(device), 0);
        unsetenv("QC_LAYERS_REFINE");
    }
    LeaveFolder();
}
END_TEST

START_TEST(damaged_files_are_compiled_anew_and_replaced)
{
    static Damage* const damages[] = {MakeEmpty,   CutHeader, CutLastByte,  AddByte,      ChangeMagic,  ChangeChecksum,
                                      ChangeSizes, ChangeTag, ChangeDriver, ChangeBinary, FillWithNoise};
    EnterCache();
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        const int compiled = Start(device);
        for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++)
        {
            Files files = ListFiles();
            DamageAll(&files, damages[i]);
            ck_assert_msg(Start(device) == compiled, "damage %zu was not noticed", i);
            ck_assert_msg(Start(device) == 0, "damage %zu was not repaired", i);
            ck_assert_int_eq(ListFiles().count, files.count);
        }
        LeaveFolder();
        EnterCache();
    }
    LeaveFolder();
}
END_TEST

START_TEST(other_things_in_the_place_of_files_are_left_alone)
{
    EnterCache();
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        const int compiled = Start(device);
        Files files = ListFiles();
        // A full folder can't be replaced, a pipe would block, and a link may point anywhere.
        for (int i = 0; i < files.count; i++)
        {
            char inside[400];
            ck_assert_int_eq(unlink(files.names[i]), 0);
            snprintf(inside, sizeof inside, "%s/file", files.names[i]);
            if (i % 3 == 0)
                ck_assert(mkdir(files.names[i], 0700) == 0 && mkdir(inside, 0700) == 0);
            else if (i % 3 == 1)
                ck_assert_int_eq(mkfifo(files.names[i], 0600), 0);
            else
                ck_assert_int_eq(symlink("/dev/zero", files.names[i]), 0);
        }
        ck_assert_int_eq(Start(device), compiled);
        ck_assert_int_eq(Start(device), (files.count + 2) / 3); // those in the place of folders
        ck_assert_int_eq(ListFiles().count, files.count);
        LeaveFolder();
        EnterCache();
    }
    LeaveFolder();
}
END_TEST

/// Starts twice with a folder where nothing can be stored.
static void StartInVain(qcDevice* device, const char* folder)
{
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = info.kind;
    def.cacheFolder = folder;
    qcDevice* other = NULL;
    CHECK_OK(qcDevice_Create(&def, &other));
    int compiled = Start(other);
    ck_assert_int_gt(compiled, 0);
    ck_assert_int_eq(Start(other), compiled);
    qcDevice_Destroy(other);
}

START_TEST(folders_that_cannot_be_written_disturb_nothing)
{
    char longest[1100], inFile[64];
    EnterCache();
    WriteText("file", "no folder");
    snprintf(inFile, sizeof inFile, "file/cache");
    memset(longest, 'x', sizeof longest);
    longest[1023] = 0;
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        StartInVain(device, "");
        StartInVain(device, inFile);
        StartInVain(device, "/proc/self/cache");
        StartInVain(device, "/dev/null");
        StartInVain(device, longest);
    }
    ck_assert_uint_eq(CountEntries(), 1);
    LeaveFolder();
}
END_TEST

/// While a binary is written: the limit of a file's size. The test's own files must not meet it.
static enum { disk_usable, disk_fillsNext, disk_full } s_disk;
static struct rlimit s_limit;

static void LimitFiles(rlim_t bytes)
{
    struct rlimit limit = s_limit;
    limit.rlim_cur = bytes < limit.rlim_cur ? bytes : limit.rlim_cur;
    (void)setrlimit(RLIMIT_FSIZE, &limit);
}

static void APIENTRY GiveBeforeFull(GLuint program, GLsizei size, GLsizei* length, GLenum* format, void* binary)
{
    s_real.GetProgramBinary(program, size, length, format, binary);
    s_disk = disk_fillsNext;
}

/// Called before the file is written, and after.
static GLenum APIENTRY FillOrRestore(void)
{
    if (s_disk != disk_usable)
        LimitFiles(s_disk == disk_fillsNext ? 1000 : RLIM_INFINITY);
    s_disk = s_disk == disk_fillsNext ? disk_full : disk_usable;
    return s_real.GetError();
}

static void OnFullDisk(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetProgramBinary = GiveBeforeFull;
    gl->GetError = FillOrRestore;
}

START_TEST(a_full_disk_leaves_no_file_behind)
{
    EnterCache();
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &s_limit), 0);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        ck_assert_int_gt(StartWith(device, OnFullDisk), 0);
        ck_assert_int_eq(s_disk, disk_usable);
        ck_assert_int_eq(Run("test -d a/cache && test -z \"$(ls -A a/cache)\""), 0);
    }
    LeaveFolder();
}
END_TEST

//  ---- drivers -----------------------------------------------------------------------------------------------------

static void APIENTRY ReportNoFormat(GLenum name, GLint* value)
{
    if (name == GL_NUM_PROGRAM_BINARY_FORMATS)
        *value = 0;
    else
        s_real.GetIntegerv(name, value);
}

static void APIENTRY ReportOtherFormat(GLenum name, GLint* value)
{
    s_real.GetIntegerv(name, value);
    if (name == GL_PROGRAM_BINARY_FORMATS)
        value[0]++;
}

/// Refuses without an error; the program is not linked.
static void APIENTRY RefuseBinary(GLuint program, GLenum format, const void* binary, GLsizei length)
{
    static const char noise[64];
    (void)length;
    s_real.ProgramBinary(program, format, noise, (GLsizei)sizeof noise);
    while (s_real.GetError() != GL_NO_ERROR)
        continue;
    (void)binary;
}

static void APIENTRY RefuseFormat(GLuint program, GLenum format, const void* binary, GLsizei length)
{
    (void)format;
    s_real.ProgramBinary(program, 0xdead, binary, length); // GL_INVALID_ENUM
}

static void APIENTRY GiveNothing(GLuint program, GLsizei size, GLsizei* length, GLenum* format, void* binary)
{
    (void)program;
    (void)size;
    (void)binary;
    *length = 0;
    *format = 0;
}

static void APIENTRY GiveError(GLuint program, GLsizei size, GLsizei* length, GLenum* format, void* binary)
{
    (void)size;
    s_real.GetProgramBinary(program, 1, length, format, binary); // GL_INVALID_OPERATION
}

static void WithoutFormats(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetIntegerv = ReportNoFormat;
}

static void WithOtherFormat(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetIntegerv = ReportOtherFormat;
}

static void WithoutFunctions(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetProgramBinary = NULL;
    gl->ProgramBinary = NULL;
    gl->ProgramParameteri = NULL;
}

static void Refusing(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->ProgramBinary = RefuseBinary;
}

static void RefusingLoudly(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->ProgramBinary = RefuseFormat;
}

static void GivingNothing(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetProgramBinary = GiveNothing;
}

static void GivingErrors(struct qcGlFunctions* gl)
{
    CountAll(gl);
    gl->GetProgramBinary = GiveError;
}

START_TEST(drivers_that_refuse_or_lack_binaries_compile)
{
    static qcReplace* const storing[] = {WithoutFormats, WithoutFunctions, GivingNothing, GivingErrors};
    static qcReplace* const loading[] = {WithoutFormats, WithOtherFormat, WithoutFunctions, Refusing, RefusingLoudly};
    EnterCache();
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        for (size_t i = 0; i < sizeof storing / sizeof storing[0]; i++)
            ck_assert_int_gt(StartWith(device, storing[i]), 0);
        ck_assert_int_eq(ListFiles().count, 0);
        int compiled = Start(device);
        for (size_t i = 0; i < sizeof loading / sizeof loading[0]; i++)
            ck_assert_int_eq(StartWith(device, loading[i]), compiled);
        ck_assert_int_eq(Start(device), 0);
        LeaveFolder();
        EnterCache();
    }
    LeaveFolder();
}
END_TEST

static void* OpenAndUse(void* context)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = *(const qcDeviceKind*)context;
    qcDevice* device = NULL;
    CHECK_OK(qcDevice_Create(&def, &device));
    World world = MakeWorld(device);
    CheckAnswered(CheckPairs(world.scene, 0.0));
    qcScene_Destroy(world.scene);
    qcDevice_Destroy(device);
    return NULL;
}

START_TEST(devices_that_start_at_once_share_a_folder)
{
    EnterCache();
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        if (!HasBinaries(device))
            continue;
        pthread_t threads[3];
        for (int i = 0; i < 3; i++)
            ck_assert_int_eq(pthread_create(&threads[i], NULL, OpenAndUse, &info.kind), 0);
        for (int i = 0; i < 3; i++)
            pthread_join(threads[i], NULL);
        Files files = ListFiles();
        for (int i = 0; i < files.count; i++)
            ck_assert_ptr_null(strstr(files.names[i], ".tmp"));
        ck_assert_int_eq(Start(device), 0);
    }
    LeaveFolder();
}
END_TEST

/// Opens a device by the default definition; the number of files in the folder that it should use.
static void CheckPlace(const char* folder, int files)
{
    char command[512];
    QC_FOR_EACH_DEVICE(device)
    {
        if (!HasBinaries(device))
            continue;
        Start(device);
        snprintf(command, sizeof command, "test $(ls %s 2>/dev/null | wc -l) %s 0 && rm -rf a cache home", folder,
                 files != 0 ? "-gt" : "-eq");
        ck_assert_msg(Run("%s", command) == 0, "%s", folder);
    }
}

START_TEST(the_environment_names_the_folder)
{
    char here[400], path[512];
    EnterCache();
    ck_assert_ptr_nonnull(getcwd(here, sizeof here));
    CheckPlace("a/cache", 1);
    setenv("QC_PROGRAM_CACHE", "off", 1);
    snprintf(path, sizeof path, "%s/home", here);
    setenv("HOME", path, 1);
    snprintf(path, sizeof path, "%s/cache", here);
    setenv("XDG_CACHE_HOME", path, 1);
    CheckPlace("off cache home", 0);
    unsetenv("QC_PROGRAM_CACHE");
    CheckPlace("cache/quickcullide", 1);
    setenv("XDG_CACHE_HOME", "cache", 1);
    CheckPlace("home/.cache/quickcullide", 1);
    unsetenv("HOME");
    CheckPlace("cache home", 0);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("program cache", a_second_start_compiles_nothing_and_finds_the_same_pairs,
                        damaged_files_are_compiled_anew_and_replaced, other_things_in_the_place_of_files_are_left_alone,
                        folders_that_cannot_be_written_disturb_nothing, a_full_disk_leaves_no_file_behind,
                        drivers_that_refuse_or_lack_binaries_compile, devices_that_start_at_once_share_a_folder,
                        the_environment_names_the_folder)
