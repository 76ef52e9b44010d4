// Pieces in files: what is saved is loaded bit by bit, and whatever is damaged is refused with its place.
#include "bullet/fracture/fracture_models.h"

#include "quickcullide/hash.h"
#include "recording/format.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

// After the standard headers: check defines a macro named fail.
#include "support/run_program.h"
#include "support/sanitizers.h"
#include "support/suite.h"
#include "support/write_bytes.h"

namespace
{
const std::string s_path = "pieces.qcp";

std::vector<unsigned char> ReadBytes()
{
    std::FILE* file = std::fopen(s_path.c_str(), "rb");
    ck_assert_ptr_nonnull(file);
    std::vector<unsigned char> bytes;
    for (int c; (c = std::fgetc(file)) != EOF;)
        bytes.push_back(static_cast<unsigned char>(c));
    std::fclose(file);
    return bytes;
}

void WritePieces(const std::vector<unsigned char>& bytes)
{
    WriteBytes(s_path.c_str(), bytes.data(), bytes.size());
}

qcFracture SomePieces(uint32_t sites)
{
    qcFractureDef def = qcTorusToBreak(8, 5, 1, 0.4);
    qcScatterInside(&def, sites, 3);
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
    return fracture;
}

bool AreSame(const btVector3& a, const btVector3& b)
{
    return std::memcmp(&a, &b, 3 * sizeof(btScalar)) == 0;
}

void CheckSame(const qcFracture& a, const qcFracture& b)
{
    ck_assert(a.volume == b.volume && a.lostVolume == b.lostVolume);
    ck_assert(a.triangleCount == b.triangleCount && a.siteCount == b.siteCount);
    ck_assert_uint_eq(a.pieces.size(), b.pieces.size());
    for (size_t i = 0; i < a.pieces.size(); i++)
    {
        const qcPiece &x = a.pieces[i], &y = b.pieces[i];
        ck_assert(x.indices == y.indices && x.sources == y.sources);
        ck_assert(x.firstCutTriangle == y.firstCutTriangle && x.site == y.site && x.volume == y.volume);
        ck_assert_uint_eq(x.vertices.size(), y.vertices.size());
        for (size_t v = 0; v < x.vertices.size(); v++)
            ck_assert(AreSame(x.vertices[v], y.vertices[v]));
        for (int row = 0; row < 3; row++)
            ck_assert(AreSame(x.frame.getBasis()[row], y.frame.getBasis()[row]));
        ck_assert(AreSame(x.frame.getOrigin(), y.frame.getOrigin()) && AreSame(x.inertia, y.inertia));
    }
    ck_assert_uint_eq(a.bonds.size(), b.bonds.size());
    for (size_t i = 0; i < a.bonds.size(); i++)
    {
        const qcBond &x = a.bonds[i], &y = b.bonds[i];
        ck_assert(x.pieceA == y.pieceA && x.pieceB == y.pieceB && x.area == y.area);
        ck_assert(AreSame(x.center, y.center) && AreSame(x.normal, y.normal));
    }
}

START_TEST(pieces_are_loaded_as_they_were_saved_bit_by_bit)
{
    for (uint32_t sites : {1u, 12u, 200u})
    {
        qcFracture fracture = SomePieces(sites);
        std::string message;
        ck_assert_msg(qcFracture_Save(fracture, s_path.c_str(), &message) == qc_statusOk, "%s", message.c_str());
        qcFracture loaded = qcFracture_Load(s_path.c_str());
        ck_assert_msg(loaded.status == qc_statusOk, "%s", loaded.message.c_str());
        CheckSame(loaded, fracture);
        // Saved again, over the old file: the same bytes.
        std::vector<unsigned char> bytes = ReadBytes();
        ck_assert_int_eq(qcFracture_Save(loaded, s_path.c_str()), qc_statusOk);
        ck_assert(ReadBytes() == bytes);
        std::remove(s_path.c_str());
    }
}
END_TEST

/// Loads a damaged file: no piece, a message that names the file.
std::string RefusedMessage()
{
    qcFracture refused = qcFracture_Load(s_path.c_str());
    ck_assert_int_eq(refused.status, qc_statusFile);
    ck_assert(refused.pieces.empty() && refused.bonds.empty());
    std::string start = "qcFracture_Load: " + s_path + ": ";
    ck_assert_msg(refused.message.compare(0, start.size(), start) == 0, "%s", refused.message.c_str());
    return refused.message.substr(start.size());
}

void CheckRefused(const std::string& expected)
{
    std::string message = RefusedMessage();
    ck_assert_str_eq(message.c_str(), expected.c_str());
}

/// The file of three pieces of a box, which is small: most tests load it for each of its bytes.
std::vector<unsigned char> SavedBytes()
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    qcScatterInside(&def, 3, 3);
    ck_assert_int_eq(qcFracture_Save(qcFracture_Split(def), s_path.c_str()), qc_statusOk);
    return ReadBytes();
}

START_TEST(a_file_that_ends_early_is_refused_wherever_it_ends)
{
    const std::vector<unsigned char> whole = SavedBytes();
    for (size_t size = 0; size < whole.size(); size++)
    {
        WritePieces({whole.begin(), whole.begin() + long(size)});
        std::string message = RefusedMessage();
        if (size >= 8)
            ck_assert_msg(message.find("ends within") != std::string::npos, "%s", message.c_str());
    }
    std::vector<unsigned char> longer = whole;
    longer.push_back(0);
    WritePieces(longer);
    ck_assert(RefusedMessage().find("bytes follow its end") != std::string::npos);
    WritePieces(whole);
    ck_assert_int_eq(qcFracture_Load(s_path.c_str()).status, qc_statusOk);
    std::remove(s_path.c_str());
}
END_TEST

START_TEST(a_file_with_any_byte_changed_is_refused)
{
    std::vector<unsigned char> bytes = SavedBytes();
    for (size_t i = 0; i < bytes.size(); i++)
        for (int flip : {0x01, 0x80, 0xff})
        {
            bytes[i] = (unsigned char)(bytes[i] ^ flip);
            WritePieces(bytes);
            RefusedMessage();
            bytes[i] = (unsigned char)(bytes[i] ^ flip);
        }
    std::remove(s_path.c_str());
}
END_TEST

/// Calls function(at, size) for each record's head and data in a file.
template <typename Function> void ForEachRecord(const std::vector<unsigned char>& bytes, Function function)
{
    for (size_t at = sizeof(qcFileHeader); at < bytes.size();)
    {
        qcRecordHead head;
        std::memcpy(&head, &bytes[at], sizeof head);
        function(at, sizeof head + size_t(head.size));
        at += sizeof head + size_t(head.size) + sizeof(uint64_t);
    }
}

/// Makes all hashes right again.
void Sign(std::vector<unsigned char>* bytes)
{
    uint64_t hash = qcXxh64(bytes->data(), offsetof(qcFileHeader, hash), 0), number = 0;
    std::memcpy(bytes->data() + offsetof(qcFileHeader, hash), &hash, sizeof hash);
    ForEachRecord(*bytes,
                  [&](size_t at, size_t size)
                  {
                      hash = qcXxh64(bytes->data() + at, size, number++);
                      std::memcpy(bytes->data() + at + size, &hash, sizeof hash);
                  });
}

START_TEST(contents_are_checked_although_their_hashes_are_right)
{
    // What is accepted has indices, sources and numbers in range.
    const std::vector<unsigned char> whole = SavedBytes();
    uint64_t state = 1;
    int refused = 0;
    for (int i = 0; i < 2000; i++)
    {
        std::vector<unsigned char> bytes = whole;
        state = state * 6364136223846793005u + 1442695040888963407u;
        size_t record = size_t(state >> 33) % 6, number = 0;
        ForEachRecord(bytes,
                      [&](size_t at, size_t size)
                      {
                          state = state * 6364136223846793005u + 1442695040888963407u;
                          // The head's size stays: records are found by it.
                          size_t place = size_t(state >> 33) % size;
                          if (number++ == record && (place < 8 || place >= 16))
                              bytes[at + place] = static_cast<unsigned char>(state >> 24);
                      });
        Sign(&bytes);
        WritePieces(bytes);
        qcFracture fracture = qcFracture_Load(s_path.c_str());
        refused += fracture.status != qc_statusOk;
        for (const qcPiece& piece : fracture.pieces)
        {
            for (uint32_t index : piece.indices)
                ck_assert_uint_lt(index, piece.vertices.size());
            for (size_t t = 0; t < piece.firstCutTriangle; t++)
                ck_assert_uint_lt(piece.sources[t], fracture.triangleCount);
            ck_assert_uint_le(piece.firstCutTriangle, piece.sources.size());
            ck_assert_uint_lt(piece.site, fracture.siteCount);
        }
        for (const qcBond& bond : fracture.bonds)
            ck_assert(bond.pieceA < bond.pieceB && bond.pieceB < fracture.pieces.size());
    }
    ck_assert_int_gt(refused, 200);
    std::remove(s_path.c_str());
}
END_TEST

START_TEST(moments_that_single_precision_does_not_hold_are_loaded_as_zeros)
{
    std::vector<unsigned char> bytes = SavedBytes();
    const double moments[3] = {1e50, 1e-50, 2};
    // Behind four numbers, the volume and the frame: plugin/docs/piece_files.md.
    constexpr size_t offset = 4 * sizeof(uint32_t) + sizeof(double) + 12 * sizeof(double);
    size_t number = 0;
    ForEachRecord(bytes,
                  [&](size_t at, size_t)
                  {
                      // The first piece.
                      if (number++ == 1)
                          std::memcpy(&bytes[at + sizeof(qcRecordHead) + offset], moments, sizeof moments);
                  });
    Sign(&bytes);
    WritePieces(bytes);
    const qcFracture fracture = qcFracture_Load(s_path.c_str());
    ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
    const bool isSingle = sizeof(btScalar) == sizeof(float);
    for (int i = 0; i < 3; i++)
        ck_assert_double_eq(double(fracture.pieces[0].inertia[i]), isSingle && i < 2 ? 0 : moments[i]);
    std::remove(s_path.c_str());
}
END_TEST

START_TEST(messages_name_the_place)
{
    const std::vector<unsigned char> whole = SavedBytes();
    std::vector<size_t> starts;
    ForEachRecord(whole, [&](size_t at, size_t) { starts.push_back(at); });
    ck_assert_uint_ge(starts.size(), 6); // the fracture, 3 pieces, bonds, end
    std::vector<unsigned char> bytes = whole;
    bytes[starts[2] + 200] ^= 1;
    WritePieces(bytes);
    CheckRefused("piece 1 at byte " + std::to_string(starts[2]) + ": it is damaged: its hash differs");
    bytes = whole;
    uint32_t version = 2;
    std::memcpy(&bytes[8], &version, sizeof version);
    Sign(&bytes);
    WritePieces(bytes);
    CheckRefused("its format is version 2; this library reads version 1");
    bytes = whole;
    bytes[3] = 'R'; // a recording
    WritePieces(bytes);
    CheckRefused("it is no file of pieces");
    std::remove(s_path.c_str());
    CheckRefused("it can't be opened: No such file or directory");
}
END_TEST

START_TEST(no_path_is_refused)
{
    const qcFracture fracture = qcFracture_Load(nullptr);
    ck_assert_int_eq(fracture.status, qc_statusBadInput);
    ck_assert_str_eq(fracture.message.c_str(), "qcFracture_Load: path is null");
    ck_assert_str_eq(qcLastMessage(), fracture.message.c_str());
    std::string message;
    ck_assert_int_eq(qcFracture_Save(fracture, nullptr, &message), qc_statusBadInput);
    ck_assert_str_eq(message.c_str(), "qcFracture_Save: path is null");
    ck_assert_int_eq(qcFracture_Save(fracture, nullptr), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), message.c_str());
}
END_TEST

START_TEST(an_old_file_stays_until_the_new_one_is_complete)
{
    const qcFracture few = SomePieces(3), many = SomePieces(40);
    std::string message;
    ck_assert_int_eq(qcFracture_Save(few, s_path.c_str()), qc_statusOk);
    const std::vector<unsigned char> old = ReadBytes();
    const size_t entries = CountEntries();
    rlimit limit, before;
    ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &before), 0);
    limit = before;
    limit.rlim_cur = old.size() / 2;
    signal(SIGXFSZ, SIG_IGN);
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
    const qcStatus status = qcFracture_Save(many, s_path.c_str(), &message);
    ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &before), 0);
    ck_assert_int_eq(status, qc_statusFile);
    ck_assert_msg(message.find("can't be written") != std::string::npos, "%s", message.c_str());
    ck_assert(ReadBytes() == old);
    ck_assert_uint_eq(CountEntries(), entries);
    // By a link the file behind it is replaced.
    ck_assert_int_eq(symlink(s_path.c_str(), "link.qcp"), 0);
    ck_assert_int_eq(chmod(s_path.c_str(), 0640), 0);
    ck_assert_int_eq(qcFracture_Save(many, "link.qcp"), qc_statusOk);
    CheckSame(qcFracture_Load(s_path.c_str()), many);
    struct stat link, file;
    ck_assert(lstat("link.qcp", &link) == 0 && S_ISLNK(link.st_mode));
    ck_assert(stat(s_path.c_str(), &file) == 0 && (file.st_mode & 0777) == 0640);
    std::remove("link.qcp");
    std::remove(s_path.c_str());
}
END_TEST

START_TEST(a_link_to_nothing_stays_and_its_target_is_made)
{
    const qcFracture fracture = SomePieces(3);
    ck_assert_int_eq(mkdir("folder", 0777), 0);
    ck_assert_int_eq(symlink("folder/second.qcp", "first.qcp"), 0);
    ck_assert_int_eq(symlink("made.qcp", "folder/second.qcp"), 0);
    ck_assert_int_eq(qcFracture_Save(fracture, "first.qcp"), qc_statusOk);
    CheckSame(qcFracture_Load("folder/made.qcp"), fracture);
    for (const char* name : {"first.qcp", "folder/second.qcp"})
    {
        struct stat link;
        ck_assert(lstat(name, &link) == 0 && S_ISLNK(link.st_mode));
    }
    ck_assert_int_eq(symlink("two.qcp", "one.qcp"), 0);
    ck_assert_int_eq(symlink("one.qcp", "two.qcp"), 0);
    const size_t entries = CountEntries();
    std::string message;
    ck_assert_int_eq(qcFracture_Save(fracture, "one.qcp", &message), qc_statusFile);
    ck_assert_str_eq(message.c_str(), "qcFracture_Save: one.qcp can't be created: Too many levels of symbolic links");
    ck_assert_uint_eq(CountEntries(), entries);
    for (const char* name : {"first.qcp", "folder/second.qcp", "folder/made.qcp", "one.qcp", "two.qcp", "folder"})
        std::remove(name);
}
END_TEST

START_TEST(new_files_have_the_permissions_of_all_new_files_on_several_threads)
{
    const qcFracture fracture = SomePieces(2);
    const mode_t mask = umask(027);
    std::vector<std::thread> threads;
    std::atomic<int> wrong{0};
    for (int i = 0; i < 4; i++)
        threads.emplace_back(
            [&, i]
            {
                const std::string path = "thread" + std::to_string(i) + ".qcp";
                for (int k = 0; k < 200; k++)
                {
                    struct stat file;
                    wrong += qcFracture_Save(fracture, path.c_str()) != qc_statusOk;
                    wrong += stat(path.c_str(), &file) != 0 || (file.st_mode & 0777) != 0640;
                    std::remove(path.c_str());
                    // What the application makes meanwhile gets its permissions, too.
                    std::fclose(std::fopen(path.c_str(), "wb"));
                    wrong += stat(path.c_str(), &file) != 0 || (file.st_mode & 0777) != 0640;
                    std::remove(path.c_str());
                }
            });
    for (std::thread& thread : threads)
        thread.join();
    ck_assert_int_eq(umask(mask), 027);
    ck_assert_int_eq(wrong, 0);
}
END_TEST

START_TEST(a_file_that_does_not_fit_into_memory_is_refused)
{
    const std::vector<unsigned char> other(8, 'x');
    WritePieces(other);
    ck_assert_int_eq(truncate(s_path.c_str(), off_t(1) << 40), 0);
    CheckRefused("it is no file of pieces");
    if (!qcCanLimitAddresses())
        return;
    rlimit limit, before;
    ck_assert_int_eq(getrlimit(RLIMIT_AS, &before), 0);
    limit = before;
    limit.rlim_cur = rlim_t(1) << 30;
    ck_assert_int_eq(qcFracture_Save(SomePieces(2), s_path.c_str()), qc_statusOk);
    ck_assert_int_eq(truncate(s_path.c_str(), off_t(1) << 40), 0);
    ck_assert_int_eq(setrlimit(RLIMIT_AS, &limit), 0);
    const qcFracture fracture = qcFracture_Load(s_path.c_str());
    ck_assert_int_eq(setrlimit(RLIMIT_AS, &before), 0);
    ck_assert_int_eq(fracture.status, qc_statusOutOfMemory);
    ck_assert(fracture.pieces.empty());
    std::remove(s_path.c_str());
}
END_TEST

START_TEST(pieces_that_were_changed_wrongly_are_not_saved)
{
    qcFracture fracture = SomePieces(3);
    std::string message;
    auto refuse = [&](const qcFracture& wrong, const char* place)
    {
        ck_assert_int_eq(qcFracture_Save(wrong, s_path.c_str(), &message), qc_statusBadInput);
        ck_assert_msg(message.find(place) != std::string::npos, "%s", message.c_str());
        ck_assert_int_ne(access(s_path.c_str(), F_OK), 0);
    };
    qcFracture wrong = fracture;
    wrong.pieces[1].indices[4] = 10000;
    refuse(wrong, "piece 1: index 4 is 10000 of ");
    wrong = fracture;
    wrong.pieces[0].vertices[2][1] = std::numeric_limits<btScalar>::quiet_NaN();
    refuse(wrong, "piece 0: vertex 2 is not finite");
    for (double volume : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    {
        wrong = fracture;
        wrong.pieces[1].volume = volume;
        refuse(wrong, "piece 1: its volume");
    }
    wrong = fracture;
    wrong.pieces[2].sources.pop_back();
    refuse(wrong, "piece 2: ");
    wrong = fracture;
    wrong.bonds[0].pieceB = 99;
    refuse(wrong, "bond 0: it joins pieces ");
    refuse(qcFracture_Split(qcFractureDef()), "its status is bad input");
    refuse(qcFracture(), "it has no sites");
    ck_assert_int_eq(qcFracture_Save(fracture, "/nowhere/at/all.qcp", &message), qc_statusFile);
    ck_assert_str_eq(message.c_str(),
                     "qcFracture_Save: /nowhere/at/all.qcp can't be created: No such file or directory");
    ck_assert_int_eq(qcFracture_Save(fracture, "/dev/full", &message), qc_statusFile);
    ck_assert_str_eq(message.c_str(), "qcFracture_Save: /dev/full can't be written: No space left on device");
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    const TTest* const tests[] = {pieces_are_loaded_as_they_were_saved_bit_by_bit,
                                  a_file_that_ends_early_is_refused_wherever_it_ends,
                                  a_file_with_any_byte_changed_is_refused,
                                  contents_are_checked_although_their_hashes_are_right,
                                  moments_that_single_precision_does_not_hold_are_loaded_as_zeros,
                                  messages_name_the_place,
                                  no_path_is_refused,
                                  an_old_file_stays_until_the_new_one_is_complete,
                                  a_link_to_nothing_stays_and_its_target_is_made,
                                  new_files_have_the_permissions_of_all_new_files_on_several_threads,
                                  a_file_that_does_not_fit_into_memory_is_refused,
                                  pieces_that_were_changed_wrongly_are_not_saved};
    TCase* testCase = qcMakeCase("piece_files");
    tcase_add_checked_fixture(testCase, EnterFolder, LeaveFolder);
    for (const TTest* test : tests)
        tcase_add_test(testCase, test);
    return qcRunCase("piece_files", testCase);
}
