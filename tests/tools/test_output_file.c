// Output files and pictures that appear when they are complete; progress on standard error.
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE 700
#include "common/output_file.h"
#include "common/png_file.h"
#include "common/progress.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <png.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static void AssertText(const char* path, const char* expected)
{
    char text[256];
    ck_assert(ReadText(path, text, sizeof text));
    ck_assert_str_eq(text, expected);
}

START_TEST(an_old_file_stays_until_the_new_one_is_complete)
{
    qcOutput output;
    qcMessage message;
    WriteText("a", "old");
    ck_assert(qcOutput_Open("a", &output, &message));
    fputs("new", output.stream);
    fflush(output.stream);
    AssertText("a", "old");
    ck_assert_msg(qcOutput_Commit(&output, &message), "%s", message.text);
    AssertText("a", "new");
    ck_assert_uint_eq(CountEntries(), 1);
}
END_TEST

START_TEST(an_aborted_output_leaves_the_folder_as_it_was)
{
    qcOutput output;
    qcMessage message;
    WriteText("a", "old");
    ck_assert(qcOutput_Open("a", &output, &message));
    fputs("new", output.stream);
    qcOutput_Abort(&output);
    ck_assert(qcOutput_Check("a", &message));
    ck_assert(qcOutput_Check("b", &message));
    AssertText("a", "old");
    ck_assert_uint_eq(CountEntries(), 1);
}
END_TEST

START_TEST(a_signal_leaves_no_half_written_file)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    WriteText("a", "old");
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i)
    {
        fflush(NULL);
        pid_t child = fork();
        ck_assert_int_ge(child, 0);
        if (child == 0)
        {
            qcOutput outputs[2];
            qcMessage message;
            signal(signals[i], SIG_DFL);
            if (!qcOutput_Open("a", &outputs[0], &message) || !qcOutput_Open("b", &outputs[1], &message))
                _exit(1);
            fputs("new", outputs[0].stream);
            fflush(outputs[0].stream);
            raise(signals[i]);
            _exit(2);
        }
        int status;
        ck_assert_int_eq(waitpid(child, &status, 0), child);
        ck_assert(WIFSIGNALED(status));
        ck_assert_int_eq(WTERMSIG(status), signals[i]);
        AssertText("a", "old");
        ck_assert_uint_eq(CountEntries(), 1);
    }
}
END_TEST

START_TEST(a_signal_that_the_host_ignores_stays_ignored)
{
    qcOutput output;
    qcMessage message;
    signal(SIGHUP, SIG_IGN);
    ck_assert(qcOutput_Open("a", &output, &message));
    raise(SIGHUP);
    ck_assert(qcOutput_Commit(&output, &message));
    AssertText("a", "");
}
END_TEST

static mode_t GetMode(const char* path)
{
    struct stat status;
    ck_assert_int_eq(stat(path, &status), 0);
    return status.st_mode & 0777;
}

START_TEST(a_new_file_is_an_ordinary_one_and_an_old_one_keeps_its_mode)
{
    qcOutput output;
    qcMessage message;
    umask(022);
    ck_assert(qcOutput_Open("a", &output, &message));
    ck_assert(qcOutput_Commit(&output, &message));
    ck_assert_uint_eq(GetMode("a"), 0644);
    ck_assert_int_eq(chmod("a", 0600), 0);
    ck_assert(qcOutput_Open("a", &output, &message));
    ck_assert(qcOutput_Commit(&output, &message));
    ck_assert_uint_eq(GetMode("a"), 0600);
    ck_assert_uint_eq(umask(022), 022);
}
END_TEST

START_TEST(a_link_stays_a_link_and_its_file_is_replaced)
{
    qcOutput output;
    qcMessage message;
    WriteText("a", "old");
    ck_assert_int_eq(symlink("a", "link"), 0);
    ck_assert(qcOutput_Open("link", &output, &message));
    fputs("new", output.stream);
    ck_assert(qcOutput_Commit(&output, &message));
    struct stat status;
    ck_assert_int_eq(lstat("link", &status), 0);
    ck_assert(S_ISLNK(status.st_mode));
    AssertText("a", "new");
}
END_TEST

START_TEST(a_link_to_a_file_that_is_not_there_yet_stays_a_link)
{
    qcOutput output;
    qcMessage message = {""};
    struct stat status;
    // Through a chain of links, one of them in another folder; then an absolute one.
    ck_assert_int_eq(mkdir("folder", 0777), 0);
    ck_assert_int_eq(symlink("../second", "folder/first"), 0);
    ck_assert_int_eq(symlink("./folder/target", "second"), 0);
    char absolute[4096 + 16];
    ck_assert_ptr_nonnull(getcwd(absolute, 4096));
    strcat(absolute, "/folder/other");
    ck_assert_int_eq(symlink(absolute, "third"), 0);
    static const char* const links[] = {"folder/first", "third"};
    static const char* const targets[] = {"folder/target", "folder/other"};
    for (int i = 0; i < 2; ++i)
    {
        ck_assert_msg(qcOutput_Check(links[i], &message), "%s", message.text);
        ck_assert_int_ne(lstat(targets[i], &status), 0);
        ck_assert(qcOutput_Open(links[i], &output, &message));
        fputs("new", output.stream);
        ck_assert_int_ne(lstat(targets[i], &status), 0);
        ck_assert_msg(qcOutput_Commit(&output, &message), "%s", message.text);
        ck_assert_int_eq(lstat(links[i], &status), 0);
        ck_assert(S_ISLNK(status.st_mode));
        ck_assert_int_eq(lstat(targets[i], &status), 0);
        ck_assert(S_ISREG(status.st_mode));
        AssertText(targets[i], "new");
    }
    ck_assert_int_eq(unlink("folder/first"), 0);
    ck_assert_int_eq(unlink("folder/target"), 0);
    ck_assert_int_eq(unlink("folder/other"), 0);
    ck_assert_int_eq(rmdir("folder"), 0);
}
END_TEST

START_TEST(a_link_that_leads_nowhere_is_refused_and_stays)
{
    qcMessage message = {""};
    struct stat status;
    ck_assert_int_eq(symlink("there/is/none", "link"), 0);
    ck_assert(!qcOutput_Check("link", &message));
    ck_assert_str_eq(message.text, "link: No such file or directory");
    ck_assert_int_eq(symlink("loop", "loop"), 0);
    ck_assert(!qcOutput_Check("loop", &message));
    ck_assert_str_eq(message.text, "loop: Too many levels of symbolic links");
    ck_assert_int_eq(lstat("link", &status), 0);
    ck_assert(S_ISLNK(status.st_mode));
}
END_TEST

START_TEST(a_device_is_written_and_never_replaced)
{
    qcOutput output;
    qcMessage message = {""};
    ck_assert(qcOutput_Check("/dev/full", &message));
    ck_assert(qcOutput_Open("/dev/full", &output, &message));
    ck_assert_ptr_null(output.temporary);
    fputs("new", output.stream);
    ck_assert(!qcOutput_Commit(&output, &message));
    ck_assert_str_eq(message.text, "/dev/full: No space left on device");
}
END_TEST

START_TEST(a_path_that_can_not_be_written_is_named)
{
    qcMessage message = {""};
    ck_assert(!qcOutput_Check("there/is/none", &message));
    ck_assert_str_eq(message.text, "there/is/none: No such file or directory");
    ck_assert_int_eq(mkdir("folder", 0777), 0);
    ck_assert(!qcOutput_Check("folder", &message));
    ck_assert_str_eq(message.text, "folder: Is a directory");
    ck_assert_int_eq(rmdir("folder"), 0);
}
END_TEST

START_TEST(a_picture_reads_back_as_it_was_written)
{
    enum
    {
        width = 37,
        height = 11
    };
    uint8_t rgb[width * height * 3], back[sizeof rgb];
    for (size_t i = 0; i < sizeof rgb; ++i)
        rgb[i] = (uint8_t)(i * 7 + i / 256);
    qcMessage message;
    ck_assert_msg(qcPng_Write("a.png", width, height, rgb, &message), "%s", message.text);
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    ck_assert(png_image_begin_read_from_file(&image, "a.png"));
    ck_assert_uint_eq(image.width, width);
    ck_assert_uint_eq(image.height, height);
    image.format = PNG_FORMAT_RGB;
    ck_assert(png_image_finish_read(&image, NULL, back, 0, NULL));
    ck_assert_mem_eq(back, rgb, sizeof rgb);
    ck_assert_uint_eq(CountEntries(), 1);
    ck_assert(!qcPng_Write("/dev/full", width, height, rgb, &message));
    ck_assert_str_eq(message.text, "/dev/full: No space left on device");
}
END_TEST

START_TEST(long_work_shows_its_share_and_short_work_nothing)
{
    int shown[2], go[2];
    ck_assert_int_eq(pipe(shown), 0);
    ck_assert_int_eq(pipe(go), 0);
    pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0)
    {
        char byte;
        dup2(shown[1], STDERR_FILENO);
        close(shown[0]);
        close(shown[1]);
        close(go[1]);
        qcProgress_Begin(10, "short");
        qcProgress_End();
        qcProgress_Begin(10, "long");
        qcProgress_Update(5);
        // Works until the line was read.
        _exit(read(go[0], &byte, 1) == 0 ? (qcProgress_End(), 0) : 1);
    }
    close(shown[1]);
    close(go[0]);
    char text[256] = "";
    ssize_t length = read(shown[0], text, sizeof text - 1);
    close(go[1]);
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    ck_assert_int_gt(length, 0);
    ck_assert_msg(strncmp(text, "long  50 %, ", 12) == 0, "%s", text);
    length = read(shown[0], text, sizeof text - 1);
    ck_assert_int_gt(length, 0);
    ck_assert_msg(strncmp(text, "long: done, ", 12) == 0, "%s", text);
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("output_file");
    tcase_add_checked_fixture(tests, EnterFolder, LeaveFolder);
    tcase_add_test(tests, an_old_file_stays_until_the_new_one_is_complete);
    tcase_add_test(tests, an_aborted_output_leaves_the_folder_as_it_was);
    tcase_add_test(tests, a_signal_leaves_no_half_written_file);
    tcase_add_test(tests, a_signal_that_the_host_ignores_stays_ignored);
    tcase_add_test(tests, a_new_file_is_an_ordinary_one_and_an_old_one_keeps_its_mode);
    tcase_add_test(tests, a_link_stays_a_link_and_its_file_is_replaced);
    tcase_add_test(tests, a_link_to_a_file_that_is_not_there_yet_stays_a_link);
    tcase_add_test(tests, a_link_that_leads_nowhere_is_refused_and_stays);
    tcase_add_test(tests, a_device_is_written_and_never_replaced);
    tcase_add_test(tests, a_path_that_can_not_be_written_is_named);
    tcase_add_test(tests, a_picture_reads_back_as_it_was_written);
    tcase_add_test(tests, long_work_shows_its_share_and_short_work_nothing);
    return qcRunCase("output_file", tests);
}
