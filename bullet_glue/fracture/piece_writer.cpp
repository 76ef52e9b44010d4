// Writes a fracture to a file.
#include "fracture/piece_format.h"

#include "fracture/new_file.h"
#include "fracture/piece_defects.h"

#include <cstddef>
#include <cstring>

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
} // namespace

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
    std::string defect = qcFindDefect(fracture);
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
    defect = qcWriteFile(path, records.GetBytes());
    return defect.empty() ? qc_statusOk : fail(qc_statusFile, defect);
}
