// The layout of a file of pieces: plugin/docs/piece_files.md. Header and records are those of a recording
// (plugin/recording/format.h), with kinds of their own.
#ifndef QC_GLUE_FRACTURE_PIECE_FORMAT_H
#define QC_GLUE_FRACTURE_PIECE_FORMAT_H

#include "quickcullide/bullet_fracture.h"
#include "quickcullide/hash.h"

enum
{
    qc_pieceFileVersion = 1
};

#define QC_PIECE_FILE_MAGIC "\x89QCP\r\n\x1a\n"

struct qcPieceFileHeader
{
    char magic[8];
    uint32_t formatVersion, libraryVersion;
    uint64_t hash; ///< XXH64 of the 16 bytes above
};

/// Then data, padded to 8 bytes, and the XXH64 of both with the record's number as the seed.
struct qcPieceRecordHead
{
    uint32_t kind, slot;
    uint64_t size; ///< bytes of data, a multiple of 8
};

/// In this order in a file; one record for each piece.
enum qcPieceRecordKind : uint32_t
{
    qc_recordFracture = 1,
    qc_recordPiece = 2, ///< slot: its index
    qc_recordBonds = 3,
    qc_recordPiecesEnd = 4 ///< without data
};

struct qcFractureRecord
{
    uint32_t scalarSize; ///< of the pieces' vertices: 4 or 8
    uint32_t pieceCount, bondCount;
    uint32_t triangleCount, siteCount, padding;
    double volume, lostVolume;
};

/// Then vertices, indices and sources, each padded to 8 bytes.
struct qcPieceRecord
{
    uint32_t vertexCount, triangleCount, firstCutTriangle, site;
    double volume;
    double frame[12]; ///< rows of the basis, origin
    double inertia[3];
};

/// The record of bonds is an array of these.
struct qcBondRecord
{
    uint32_t pieceA, pieceB;
    double area, center[3], normal[3];
};

static_assert(sizeof(qcPieceFileHeader) == 24 && sizeof(qcPieceRecordHead) == 16, "no padding");
static_assert(sizeof(qcFractureRecord) == 40 && sizeof(qcPieceRecord) == 144 && sizeof(qcBondRecord) == 64,
              "no padding");

#endif
