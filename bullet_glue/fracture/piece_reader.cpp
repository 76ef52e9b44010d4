// Reads a fracture from a file. Nothing in a file is trusted: sizes are compared with what is there before anything is
// read, and contents are checked although their hashes are right.
#include "common/mass_properties.h"
#include "fracture/piece_defects.h"
#include "fracture/piece_format.h"

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>

namespace
{
/// Why a file is refused.
struct Refused
{
    std::string reason;
};

struct FileCloser
{
    void operator()(std::FILE* file) const
    {
        std::fclose(file);
    }
};

bool IsOfPieces(const std::vector<char>& bytes)
{
    const size_t size = sizeof qcPieceFileHeader::magic;
    return bytes.size() >= size && std::memcmp(bytes.data(), QC_PIECE_FILE_MAGIC, size) == 0;
}

/// The whole file. One that is no file of pieces, however long, is refused by its start.
std::vector<char> ReadFile(const char* path)
{
    const std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path, "rb"));
    if (file == nullptr)
        throw Refused{std::string("it can't be opened: ") + std::strerror(errno)};
    std::vector<char> bytes;
    char buffer[1 << 16];
    for (size_t count; (count = std::fread(buffer, 1, sizeof buffer, file.get())) > 0;)
    {
        bytes.insert(bytes.end(), buffer, buffer + count);
        if (!IsOfPieces(bytes))
            break;
    }
    if (std::ferror(file.get()) != 0)
        throw Refused{std::string("it can't be read: ") + std::strerror(errno)};
    if (!IsOfPieces(bytes))
        throw Refused{"it is no file of pieces"};
    return bytes;
}

/// A record's data, taken piece by piece.
class Data
{
  public:
    Data() = default;
    Data(const char* at, uint64_t left) : m_at(at), m_left(left)
    {
    }

    /// Copies `count` items, and skips the zeros that pad them to 8 bytes.
    template <typename Item> std::vector<Item> Take(uint64_t count)
    {
        if (count > m_left / sizeof(Item) || (count * sizeof(Item) + 7) / 8 * 8 > m_left)
            throw Refused{"its data is too short"};
        uint64_t size = count * sizeof(Item), padded = (size + 7) / 8 * 8;
        std::vector<Item> items(static_cast<size_t>(count));
        if (size > 0)
            std::memcpy(items.data(), m_at, static_cast<size_t>(size));
        m_at += padded;
        m_left -= padded;
        return items;
    }

    void CheckDone() const
    {
        if (m_left != 0)
            throw Refused{"its data is too long"};
    }

  private:
    const char* m_at = nullptr;
    uint64_t m_left = 0;
};

/// The records of a file, in their order.
class Records
{
  public:
    explicit Records(std::vector<char> bytes) : m_bytes(std::move(bytes))
    {
        qcPieceFileHeader header;
        if (m_bytes.size() < sizeof header)
            throw Refused{"it ends within its header, at byte " + std::to_string(m_bytes.size())};
        std::memcpy(&header, m_bytes.data(), sizeof header);
        if (header.hash != qcXxh64(&header, offsetof(qcPieceFileHeader, hash), 0))
            throw Refused{"its header, bytes 0 to 23, is damaged"};
        if (header.formatVersion != qc_pieceFileVersion)
            throw Refused{"its format is version " + std::to_string(header.formatVersion) +
                          "; this library reads version " + std::to_string(qc_pieceFileVersion)};
        m_at = sizeof header;
    }

    /// The next record, which must be of this kind and slot.
    Data Next(uint32_t kind, uint32_t slot)
    {
        m_recordStart = m_at;
        qcPieceRecordHead head;
        size_t left = m_bytes.size() - m_at;
        if (left < sizeof head + sizeof(uint64_t))
            throw Refused{"the file ends within it, at byte " + std::to_string(m_bytes.size())};
        std::memcpy(&head, &m_bytes[m_at], sizeof head);
        if (head.size > left - sizeof head - sizeof(uint64_t) || head.size % 8 != 0)
            throw Refused{"its size is damaged, or the file ends within it"};
        size_t size = sizeof head + size_t(head.size);
        uint64_t hash;
        std::memcpy(&hash, &m_bytes[m_at + size], sizeof hash);
        if (hash != qcXxh64(&m_bytes[m_at], size, m_count++))
            throw Refused{"it is damaged: its hash differs"};
        if (head.kind != kind || head.slot != slot)
            throw Refused{"it is of kind " + std::to_string(head.kind) + " and number " + std::to_string(head.slot) +
                          ", where " + std::to_string(kind) + " and " + std::to_string(slot) + " belong"};
        Data data(&m_bytes[m_at] + sizeof head, head.size);
        m_at += size + sizeof hash;
        return data;
    }

    void CheckDone() const
    {
        if (m_at != m_bytes.size())
            throw Refused{"bytes follow its end"};
    }

    /// The place of the last record.
    std::string Place() const
    {
        return m_recordStart == 0 ? "" : " at byte " + std::to_string(m_recordStart);
    }

  private:
    std::vector<char> m_bytes;
    size_t m_at = 0, m_recordStart = 0;
    uint64_t m_count = 0;
};

btVector3 VectorOf(const double* numbers)
{
    return btVector3(btScalar(numbers[0]), btScalar(numbers[1]), btScalar(numbers[2]));
}

template <typename Scalar> std::vector<btVector3> TakeVertices(uint32_t count, Data* data)
{
    std::vector<Scalar> coordinates = data->Take<Scalar>(3 * uint64_t(count));
    std::vector<btVector3> vertices(count);
    for (size_t i = 0; i < count; i++)
        vertices[i].setValue(btScalar(coordinates[3 * i]), btScalar(coordinates[3 * i + 1]),
                             btScalar(coordinates[3 * i + 2]));
    return vertices;
}

qcPiece TakePiece(uint32_t scalarSize, const qcFracture& fracture, Data data)
{
    const qcPieceRecord record = data.Take<qcPieceRecord>(1)[0];
    qcPiece piece;
    piece.vertices = scalarSize == sizeof(float) ? TakeVertices<float>(record.vertexCount, &data)
                                                 : TakeVertices<double>(record.vertexCount, &data);
    piece.indices = data.Take<uint32_t>(3 * uint64_t(record.triangleCount));
    piece.sources = data.Take<uint32_t>(record.triangleCount);
    data.CheckDone();
    piece.firstCutTriangle = record.firstCutTriangle;
    piece.site = record.site;
    piece.volume = record.volume;
    for (int i = 0; i < 3; i++)
        piece.frame.getBasis()[i] = VectorOf(&record.frame[3 * i]);
    piece.frame.setOrigin(VectorOf(&record.frame[9]));
    for (int i = 0; i < 3; i++)
        // What is not finite is refused.
        piece.inertia[i] =
            std::isfinite(record.inertia[i]) ? qcMomentOf(record.inertia[i]) : btScalar(record.inertia[i]);
    std::string defect = qcFindPieceDefect(piece, fracture);
    if (!defect.empty())
        throw Refused{defect};
    return piece;
}

void TakeBonds(uint32_t count, Data data, qcFracture* fracture)
{
    for (const qcBondRecord& record : data.Take<qcBondRecord>(count))
    {
        qcBond bond;
        bond.pieceA = record.pieceA;
        bond.pieceB = record.pieceB;
        bond.area = record.area;
        bond.center = VectorOf(record.center);
        bond.normal = VectorOf(record.normal);
        std::string defect = qcFindBondDefect(bond, *fracture);
        if (!defect.empty())
            throw Refused{"bond " + std::to_string(fracture->bonds.size()) + ": " + defect};
        fracture->bonds.push_back(bond);
    }
    data.CheckDone();
}

/// `what` receives the name of the record that is read.
qcFracture Take(Records* records, std::string* what)
{
    qcFracture fracture;
    *what = "the first record";
    Data data = records->Next(qc_recordFracture, 0);
    const qcFractureRecord head = data.Take<qcFractureRecord>(1)[0];
    data.CheckDone();
    if (head.scalarSize != sizeof(float) && head.scalarSize != sizeof(double))
        throw Refused{"its numbers have " + std::to_string(head.scalarSize) + " bytes"};
    if (!std::isfinite(head.volume) || !std::isfinite(head.lostVolume))
        throw Refused{"its volume is not finite"};
    fracture.volume = head.volume;
    fracture.lostVolume = head.lostVolume;
    fracture.triangleCount = head.triangleCount;
    fracture.siteCount = head.siteCount;
    for (uint32_t i = 0; i < head.pieceCount; i++)
    {
        *what = "piece " + std::to_string(i);
        fracture.pieces.push_back(TakePiece(head.scalarSize, fracture, records->Next(qc_recordPiece, i)));
    }
    *what = "the bonds";
    TakeBonds(head.bondCount, records->Next(qc_recordBonds, 0), &fracture);
    *what = "the last record";
    records->Next(qc_recordPiecesEnd, 0).CheckDone();
    records->CheckDone();
    return fracture;
}

qcFracture FailLoad(qcStatus status, const std::string& message)
{
    qcFracture failed;
    failed.message = "qcFracture_Load: " + message;
    failed.status = qcFail(status, "%s", failed.message.c_str());
    return failed;
}
} // namespace

qcFracture qcFracture_Load(const char* path)
{
    if (path == nullptr)
    {
        return FailLoad(qc_statusBadInput, "path is null");
    }
    std::string place;
    try
    {
        if (__BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__)
            throw Refused{"files of pieces need a little-endian machine"};
        Records records(ReadFile(path));
        std::string what;
        try
        {
            return Take(&records, &what);
        }
        catch (const Refused&)
        {
            place = ": " + what + records.Place();
            throw;
        }
    }
    catch (const Refused& refused)
    {
        return FailLoad(qc_statusFile, std::string(path) + place + ": " + refused.reason);
    }
    catch (const std::bad_alloc&)
    {
        return FailLoad(qc_statusOutOfMemory, std::string(path) + ": out of memory");
    }
}
