// Writes a fracture to a file.
#include "fracture/piece_format.h"

#include "common/finite.h"

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace
{
/// The bytes of a file, record by record.
class Records
{
  public:
    Records()
    {
        qcPieceFileHeader header = {};
        std::memcpy(header.magic, QC_PIECE_FILE_MAGIC, sizeof header.magic);
        header.formatVersion = qc_pieceFileVersion;
        header.libraryVersion = qcVersion();
        header.hash = qcXxh64(&header, offsetof(qcPieceFileHeader, hash), 0);
        Put(&header, sizeof header);
    }

    void Begin(uint32_t kind, uint32_t slot)
    {
        m_start = m_bytes.size();
        qcPieceRecordHead head = {kind, slot, 0};
        Put(&head, sizeof head);
    }

    /// Padded to 8 bytes.
    void Put(const void* data, size_t size)
    {
        const char* bytes = static_cast<const char*>(data);
        m_bytes.insert(m_bytes.end(), bytes, bytes + size);
        m_bytes.resize((m_bytes.size() + 7) / 8 * 8);
    }

    void End()
    {
        uint64_t size = m_bytes.size() - m_start - sizeof(qcPieceRecordHead);
        std::memcpy(&m_bytes[m_start + offsetof(qcPieceRecordHead, size)], &size, sizeof size);
        uint64_t hash = qcXxh64(&m_bytes[m_start], m_bytes.size() - m_start, m_count++);
        Put(&hash, sizeof hash);
    }

    const std::vector<char>& GetBytes() const
    {
        return m_bytes;
    }

  private:
    std::vector<char> m_bytes;
    size_t m_start = 0;
    uint64_t m_count = 0;
};

void PutPiece(const qcPiece& piece, Records* records)
{
    qcPieceRecord record = {};
    record.vertexCount = uint32_t(piece.vertices.size());
    record.triangleCount = uint32_t(piece.sources.size());
    record.firstCutTriangle = piece.firstCutTriangle;
    record.site = piece.site;
    record.volume = piece.volume;
    for (int i = 0; i < 3; i++)
    {
        for (int k = 0; k < 3; k++)
            record.frame[3 * i + k] = double(piece.frame.getBasis()[i][k]);
        record.frame[9 + i] = double(piece.frame.getOrigin()[i]);
        record.inertia[i] = double(piece.inertia[i]);
    }
    records->Put(&record, sizeof record);
    std::vector<btScalar> coordinates;
    for (const btVector3& vertex : piece.vertices)
        coordinates.insert(coordinates.end(), &vertex.m_floats[0], &vertex.m_floats[0] + 3);
    records->Put(coordinates.data(), coordinates.size() * sizeof(btScalar));
    records->Put(piece.indices.data(), piece.indices.size() * sizeof(uint32_t));
    records->Put(piece.sources.data(), piece.sources.size() * sizeof(uint32_t));
}

void PutBonds(const std::vector<qcBond>& bonds, Records* records)
{
    for (const qcBond& bond : bonds)
    {
        qcBondRecord record = {bond.pieceA, bond.pieceB, bond.area, {}, {}};
        for (int i = 0; i < 3; i++)
        {
            record.center[i] = double(bond.center[i]);
            record.normal[i] = double(bond.normal[i]);
        }
        records->Put(&record, sizeof record);
    }
}

std::string FindDefect(const qcFracture& fracture)
{
    if (fracture.status != qc_statusOk)
        return "its status is " + std::string(qcStatus_Name(fracture.status));
    if (fracture.siteCount == 0)
        return "it has no sites";
    if (!std::isfinite(fracture.volume) || !std::isfinite(fracture.lostVolume))
        return "its volume is not finite";
    for (size_t i = 0; i < fracture.pieces.size(); i++)
    {
        std::string defect = qcFindPieceDefect(fracture.pieces[i], fracture);
        if (!defect.empty())
            return "piece " + std::to_string(i) + ": " + defect;
    }
    for (size_t i = 0; i < fracture.bonds.size(); i++)
    {
        std::string defect = qcFindBondDefect(fracture.bonds[i], fracture);
        if (!defect.empty())
            return "bond " + std::to_string(i) + ": " + defect;
    }
    return "";
}

/// The end of a chain of symbolic links. Empty, with an error: there is none.
std::filesystem::path FollowLinks(std::filesystem::path path, std::error_code* error)
{
    constexpr int maxLinks = 40; // the limit of Linux
    for (int i = 0; i < maxLinks; i++)
    {
        if (!std::filesystem::is_symlink(std::filesystem::symlink_status(path, *error)))
            return path;
        const std::filesystem::path target = std::filesystem::read_symlink(path, *error);
        if (*error)
            return {};
        path = path.parent_path() / target; // an absolute target stands alone
    }
    *error = std::make_error_code(std::errc::too_many_symbolic_link_levels);
    return {};
}

/// A new file beside another one, which it replaces, or whose name it gets, when it is complete.
class NewFile
{
  public:
    /// A symbolic link stays: the file behind it is replaced. What is no file, as a pipe, is written itself.
    explicit NewFile(const std::string& path)
    {
        std::error_code error;
        const std::filesystem::file_status old = std::filesystem::status(path, error);
        m_isDirect = std::filesystem::exists(old) && !std::filesystem::is_regular_file(old);
        if (m_isDirect)
        {
            m_name = path;
            OpenStream(open(path.c_str(), O_WRONLY | O_CLOEXEC));
            return;
        }
        m_target = FollowLinks(path, &error).string();
        if (m_target.empty())
        {
            m_error = error.value();
            return;
        }
        OpenStream(Create());
        if (m_stream != nullptr && std::filesystem::exists(old))
            std::filesystem::permissions(m_name, old.permissions(), error);
    }

    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    ~NewFile()
    {
        if (m_stream != nullptr)
            std::fclose(m_stream);
        if (m_isTemporary)
            std::remove(m_name.c_str());
    }

    bool IsOpen() const
    {
        return m_stream != nullptr;
    }

    /// Why it is not open: a number of errno.
    int GetError() const
    {
        return m_error;
    }

    /// False, with errno: the old file is as it was.
    bool Write(const std::vector<char>& bytes)
    {
        if (std::fwrite(bytes.data(), 1, bytes.size(), m_stream) != bytes.size())
            return false;
        // Some file systems report a full disk here only.
        const bool isClosed = std::fclose(m_stream) == 0;
        m_stream = nullptr;
        if (!isClosed || m_isDirect)
            return isClosed;
        m_isTemporary = std::rename(m_name.c_str(), m_target.c_str()) != 0;
        return !m_isTemporary;
    }

  private:
    /// A new file beside the target, with the permissions that files of this process get.
    int Create()
    {
        static std::atomic<unsigned> s_last{0};
        int descriptor;
        do
        {
            m_name = m_target + "." + std::to_string(getpid()) + "." + std::to_string(++s_last);
            descriptor = open(m_name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (descriptor < 0 && errno == EEXIST);
        m_isTemporary = descriptor >= 0;
        return descriptor;
    }

    void OpenStream(int descriptor)
    {
        m_stream = descriptor >= 0 ? fdopen(descriptor, "wb") : nullptr;
        m_error = m_stream == nullptr ? errno : 0;
        if (m_stream == nullptr && descriptor >= 0)
            close(descriptor);
    }

    std::string m_target, m_name;
    std::FILE* m_stream = nullptr;
    int m_error = 0;
    bool m_isDirect;
    bool m_isTemporary = false; ///< the file m_name is to be removed
};

/// The reason why the file could not be written, or an empty text.
std::string WriteFile(const char* path, const std::vector<char>& bytes)
{
    NewFile file(path);
    if (!file.IsOpen())
        return std::string(path) + " can't be created: " + std::strerror(file.GetError());
    return file.Write(bytes) ? "" : std::string(path) + " can't be written: " + std::strerror(errno);
}
} // namespace

std::string qcFindPieceDefect(const qcPiece& piece, const qcFracture& fracture)
{
    size_t triangles = piece.sources.size();
    if (piece.indices.size() != 3 * triangles)
        return std::to_string(piece.indices.size()) + " indices for " + std::to_string(triangles) + " sources";
    if (piece.firstCutTriangle > triangles)
        return "the first triangle in a cut is " + std::to_string(piece.firstCutTriangle) + " of " +
               std::to_string(triangles);
    if (piece.site >= fracture.siteCount)
        return "its site is " + std::to_string(piece.site) + " of " + std::to_string(fracture.siteCount);
    for (size_t i = 0; i < piece.vertices.size(); i++)
        if (!qcIsFinite(piece.vertices[i]))
            return "vertex " + std::to_string(i) + " is not finite";
    for (size_t i = 0; i < piece.indices.size(); i++)
        if (piece.indices[i] >= piece.vertices.size())
            return "index " + std::to_string(i) + " is " + std::to_string(piece.indices[i]) + " of " +
                   std::to_string(piece.vertices.size()) + " vertices";
    for (size_t t = 0; t < triangles; t++)
    {
        bool isCut = t >= piece.firstCutTriangle;
        uint32_t count = isCut ? fracture.siteCount : fracture.triangleCount;
        if (piece.sources[t] >= count && !(isCut && piece.sources[t] == UINT32_MAX))
            return "the source of triangle " + std::to_string(t) + " is " + std::to_string(piece.sources[t]) + " of " +
                   std::to_string(count);
    }
    if (!std::isfinite(piece.volume) || !qcIsFinite(piece.inertia) || !qcIsFinite(piece.frame))
        return "its volume, its inertia or its frame is not finite";
    if (!(piece.volume > 0))
        return "its volume is not positive";
    return "";
}

std::string qcFindBondDefect(const qcBond& bond, const qcFracture& fracture)
{
    if (bond.pieceA >= bond.pieceB || bond.pieceB >= fracture.pieces.size())
        return "it joins pieces " + std::to_string(bond.pieceA) + " and " + std::to_string(bond.pieceB) + " of " +
               std::to_string(fracture.pieces.size());
    if (!(bond.area >= 0) || !std::isfinite(bond.area) || !qcIsFinite(bond.center) || !qcIsFinite(bond.normal))
        return "its area, its centre or its normal is not finite";
    return "";
}

qcStatus qcFracture_Save(const qcFracture& fracture, const char* path, std::string* message)
{
    auto fail = [message](qcStatus status, const std::string& reason)
    {
        const std::string text = "qcFracture_Save: " + reason;
        if (message != nullptr)
            *message = text;
        return qcFail(status, "%s", text.c_str());
    };
    if (path == nullptr)
        return fail(qc_statusBadInput, "path is null");
    std::string defect = FindDefect(fracture);
    if (!defect.empty())
        return fail(qc_statusBadInput, "the fracture can't be saved: " + defect);
    if (__BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__)
        return fail(qc_statusFile, "files of pieces need a little-endian machine");
    Records records;
    records.Begin(qc_recordFracture, 0);
    qcFractureRecord record = {uint32_t(sizeof(btScalar)),
                               uint32_t(fracture.pieces.size()),
                               uint32_t(fracture.bonds.size()),
                               fracture.triangleCount,
                               fracture.siteCount,
                               0,
                               fracture.volume,
                               fracture.lostVolume};
    records.Put(&record, sizeof record);
    records.End();
    for (size_t i = 0; i < fracture.pieces.size(); i++)
    {
        records.Begin(qc_recordPiece, uint32_t(i));
        PutPiece(fracture.pieces[i], &records);
        records.End();
    }
    records.Begin(qc_recordBonds, 0);
    PutBonds(fracture.bonds, &records);
    records.End();
    records.Begin(qc_recordPiecesEnd, 0);
    records.End();
    defect = WriteFile(path, records.GetBytes());
    return defect.empty() ? qc_statusOk : fail(qc_statusFile, defect);
}
