// Writes a fracture to a file.
#include "fracture/piece_format.h"

#include "common/finite.h"

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
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
        m_target = m_isDirect ? path : std::filesystem::weakly_canonical(path, error).string();
        m_name = m_isDirect ? path : m_target + ".XXXXXX";
        const int descriptor = m_isDirect ? open(path.c_str(), O_WRONLY) : mkstemp(&m_name[0]);
        m_stream = descriptor >= 0 ? fdopen(descriptor, "wb") : nullptr;
        m_isNamed = m_isDirect || descriptor < 0;
        if (m_isNamed)
            return;
        // mkstemp lets nobody else read.
        const mode_t mask = umask(0);
        umask(mask);
        std::filesystem::permissions(
            m_name, std::filesystem::exists(old) ? old.permissions() : std::filesystem::perms(0666 & ~mask), error);
    }

    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    ~NewFile()
    {
        if (m_stream != nullptr)
            std::fclose(m_stream);
        if (!m_isNamed)
            std::remove(m_name.c_str());
    }

    bool IsOpen() const
    {
        return m_stream != nullptr;
    }

    /// False, with errno: the old file is as it was.
    bool Write(const std::vector<char>& bytes)
    {
        if (std::fwrite(bytes.data(), 1, bytes.size(), m_stream) != bytes.size())
            return false;
        // Some file systems report a full disk here only.
        const bool isClosed = std::fclose(m_stream) == 0;
        m_stream = nullptr;
        if (!isClosed || m_isNamed)
            return isClosed;
        m_isNamed = std::rename(m_name.c_str(), m_target.c_str()) == 0;
        return m_isNamed;
    }

  private:
    std::string m_target, m_name;
    std::FILE* m_stream;
    bool m_isDirect;
    bool m_isNamed; ///< nothing is to be removed
};

/// The reason why the file could not be written, or an empty text.
std::string WriteFile(const char* path, const std::vector<char>& bytes)
{
    NewFile file(path);
    if (!file.IsOpen())
        return std::string(path) + " can't be created: " + std::strerror(errno);
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
