// The layout of a recording: plugin/docs/recording.md. Numbers are little-endian, floats are their bits.
//
// A file is a header, then records. A record is a head, its data, and the XXH64 of both with the record's number as the
// seed. Data is padded with zeros to a multiple of 8 bytes, so all numbers are aligned.
#ifndef QC_RECORDING_FORMAT_H
#define QC_RECORDING_FORMAT_H

#include <assert.h>
#include <stdint.h>

enum
{
    qc_recordingVersion = 1
};

/// A byte beyond ASCII, and line ends that a transfer as text would change, as in PNG.
#define QC_RECORDING_MAGIC "\x89QCR\r\n\x1a\n"

typedef struct qcFileHeader
{
    char magic[8];
    uint32_t formatVersion, libraryVersion;
    uint64_t hash; ///< XXH64 of the 16 bytes above
} qcFileHeader;

/// Kinds up to 63 are those of qcOperationKind.
typedef enum qcRecordKind
{
    qc_recordDevice = 64, ///< the first record; data: name of the device, ended by a zero
    qc_recordResult = 65, ///< behind each detection that returned
    qc_recordEnd = 66,    ///< the recording was closed
    qc_recordBoxes = 67   ///< in place of qc_recordDevice: of a broadphase; data: one number, the size of its numbers
} qcRecordKind;

typedef struct qcRecordHead
{
    uint32_t kind;
    uint32_t slot; ///< the body, or 0
    uint64_t size; ///< bytes of data, a multiple of 8
} qcRecordHead;

enum
{
    qc_bodyDeforming = 1,
    qc_bodySelfCollision = 2,
    qc_bodyDoubles = 4,    ///< positions are doubles
    qc_bodyNewIndices = 8, ///< the indices follow; otherwise they are those of an earlier body
    qc_bodyFlags = 15
};

/// Then positions; then, if they are new, indices. Each padded to 8 bytes.
typedef struct qcBodyRecord
{
    uint32_t flags, activity;
    uint32_t group, mask, owner;
    uint32_t indexSet; ///< number of the indices in the order in which new ones were written
    uint32_t vertexCount, triangleCount;
    double margin;
    double transform[12]; ///< linear, translation
} qcBodyRecord;

/// How positions are stored.
typedef enum qcPositionCoding
{
    qc_codingF32 = 0, ///< as they are
    qc_codingF64 = 1,
    qc_codingPackedF32 = 2, ///< position_coding.h, from the body's last two positions of this type
    qc_codingPackedF64 = 3
} qcPositionCoding;

/// Then the positions.
typedef struct qcVerticesRecord
{
    uint32_t coding, vertexCount;
} qcVerticesRecord;

/// Activity, self-collision: one number. Filter: group and mask.
typedef struct qcWordsRecord
{
    uint32_t words[2];
} qcWordsRecord;

enum
{
    qc_detectTouching = 1,
    qc_detectNeighbours = 2,
    qc_detectSegments = 4,
    qc_detectProximities = 8,
    qc_detectManifolds = 16,
    qc_detectNearestContacts = 32,
    qc_detectLayerTimes = 64,
    qc_detectBackToFront = 128,
    qc_detectSecondPassFromBack = 256,
    qc_detectReliable = 512,
    qc_detectMotion = 1024,
    qc_detectHasFilter = 2048,
    qc_detectHasSpacing = 4096,
    qc_detectUnoriented = 8192,
    qc_detectHasMaxPairs = 16384,
    qc_detectFlags = 32767
};

/// Then, with qc_detectHasSpacing, the spacing: a double. Then, with qc_detectHasMaxPairs, their number: 8 bytes.
typedef struct qcDetectRecord
{
    uint32_t method, flags, threads;
    uint32_t layerColumns, layerDepthAxis;
    uint32_t resolution, iterations;
    char views[4];
    double margin, contactMargin;
} qcDetectRecord;

/// Then the pairs of bodies that the filter rejected, 8 bytes each: (slotA << 32 | slotB) with slotA < slotB, sorted.
typedef struct qcResultRecord
{
    uint32_t status, padding;
    uint64_t hashes[10]; ///< the fields of qcResultHash
} qcResultRecord;

/// Moved boxes, and boxes that were reported: then ids (4 bytes each), then bounds or numbers of the broadphase's type.
typedef struct qcBoxesRecord
{
    uint32_t count, isDisturbed;
} qcBoxesRecord;

/// Then the bounds.
typedef struct qcBoxRecord
{
    uint32_t group, mask;
} qcBoxRecord;

/// Then the rejected pairs, 8 bytes each.
typedef struct qcPairsRecord
{
    uint32_t hasCallback, isDisturbed;
    uint64_t pairCount, pairHash;
} qcPairsRecord;

static_assert(sizeof(qcFileHeader) == 24 && sizeof(qcRecordHead) == 16 && sizeof(qcBodyRecord) == 136, "no padding");
static_assert(sizeof(qcVerticesRecord) == 8 && sizeof(qcDetectRecord) == 48 && sizeof(qcResultRecord) == 88,
              "no padding");

#endif
