/// @file
/// Recordings: files of scene operations, with hashes of what each detection reported, for a replay elsewhere by
/// another method, device or number of threads. `qc-replay` does so on the command line; plugin/docs/recording.md has
/// the format.
///
///     qcScene_Record(scene, "scene.qcr");      ...      qcScene_Record(scene, NULL);
///
/// Or, without a change to the program, QC_RECORD=PREFIX in the environment. Recordings need a little-endian machine.
#ifndef QUICKCULLIDE_RECORDING_H
#define QUICKCULLIDE_RECORDING_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

//  ---- writing -------------------------------------------------------------------------------------

/// Records the scene's operations from now on in a new file, which replaces an old one; it begins with the bodies that
/// the scene has. Null ends the recording and closes the file, as does qcScene_Destroy. A recording that runs already
/// is closed first.
///
/// A recording changes nothing else: where a later write fails, or memory runs out, it stops with one line to
/// qcSetLog, and the scene goes on. Ended with null, the call then returns qc_statusFile or qc_statusOutOfMemory with
/// the reason. What was written until then can be replayed, and so can the file of a program that crashed.
///
/// Only calls that succeed are recorded, and every qcScene_Detect with a valid definition. A pair filter is not called
/// in a replay; the pairs of bodies that it rejected are recorded. Equal calls give equal bytes.
///
/// qc_statusFile: the file can't be created or written; nothing is recorded. qc_statusOutOfMemory likewise.
/// O(size of the scene); then each operation costs O(its data).
///
/// QC_RECORD=PREFIX starts it in qcScene_Create. N in PREFIX.N.qcr is the first number that is free: no file is
/// replaced, and several processes write different files. If a file can't be created, that is logged, or written to
/// standard error where there is no log function. After fork() only the parent goes on recording.
QC_API qcStatus qcScene_Record(qcScene* scene, const char* path);

//  ---- hashes of results ---------------------------------------------------------------------------

/// Counts and hashes (XXH64 over the arrays' bytes) of what a step reported. They depend neither on the machine nor on
/// the number of threads, nor on the method among those that never miss. The potentially colliding set and the profile
/// have no part in them.
typedef struct qcResultHash
{
    uint64_t pairCount;          ///< qcResult::pairCount
    uint64_t pairs;              ///< of qcResult::pairs
    uint64_t segments;           ///< of qcResult::segments
    uint64_t proximities;        ///< of qcResult::proximities
    uint64_t contactCount;       ///< qcResult::contactCount
    uint64_t contacts;           ///< of qcResult::contacts
    uint64_t manifoldCount;      ///< qcResult::manifoldCount
    uint64_t manifolds;          ///< of qcResult::manifolds
    uint64_t manifoldPointCount; ///< qcResult::manifoldPointCount
    uint64_t manifoldPoints;     ///< of qcResult::manifoldPoints
} qcResultHash;

/// Hashes a result. O(its size).
QC_API qcResultHash qcResult_Hash(const qcResult* result);

//  ---- reading -------------------------------------------------------------------------------------

/// A recording that is being read. One thread at a time.
///
///     qcRecording_Open("scene.qcr", &recording);
///     do
///         qcRecording_Next(recording, &operation), qcOperation_Apply(operation, scene, &result);
///     while (operation->kind != qc_operationEnd);
typedef struct qcRecording qcRecording;

/// About a recording.
typedef struct qcRecordingInfo
{
    uint32_t formatVersion;  ///< 1
    uint32_t libraryVersion; ///< qcVersion() of the program that recorded
    const char* device; ///< the scene's GL device, such as "llvmpipe ..."; "none". Valid until the recording is closed
} qcRecordingInfo;

/// Opens a file. qc_statusFile: it can't be read, is no recording, or is of a newer format; the message names the
/// reason. qc_statusOutOfMemory.
QC_API qcStatus qcRecording_Open(const char* path, qcRecording** recording);
/// Closes the file. Null is allowed.
QC_API void qcRecording_Close(qcRecording* recording);
/// See qcRecordingInfo. O(1).
QC_API qcRecordingInfo qcRecording_GetInfo(const qcRecording* recording);

/// What an operation does.
typedef enum qcOperationKind
{
    qc_operationEnd = 0,              ///< there are no more operations
    qc_operationAddBody = 1,          ///< qcScene_AddBody
    qc_operationRemoveBody = 2,       ///< qcScene_RemoveBody
    qc_operationSetTransform = 3,     ///< qcScene_SetTransform
    qc_operationSetVertices = 4,      ///< qcScene_SetVertices
    qc_operationSetActivity = 5,      ///< qcScene_SetActivity
    qc_operationSetFilter = 6,        ///< qcScene_SetFilter
    qc_operationSetSelfCollision = 7, ///< qcScene_SetSelfCollision
    qc_operationSetMargin = 8,        ///< qcScene_SetMargin
    qc_operationMarkStart = 9,        ///< qcScene_MarkStart
    qc_operationDetect = 10           ///< qcScene_Detect
} qcOperationKind;

/// "end", "add body", "remove body" ... Static.
QC_API const char* qcOperationKind_Name(qcOperationKind kind);

/// One operation. Fields that its kind does not name are zero.
typedef struct qcOperation
{
    qcOperationKind kind; ///< which fields below are set
    uint64_t number;      ///< of the operation in the file, from 0
    uint64_t byteOffset;  ///< of the operation in the file
    /// The body of all kinds but end, mark start and detect. Valid in a scene that was empty and new when the first
    /// operation was applied, and had no other operations since: the slots are then those of the recorded scene.
    qcBodyId id;
    qcBodyDef body;              ///< add body: tightly packed, and no null pointer but for an empty body
    qcTransform transform;       ///< set transform
    const void* positions;       ///< set vertices: tightly packed
    qcPositionType positionType; ///< set vertices
    uint32_t vertexCount;        ///< set vertices: the body's
    qcActivity activity;         ///< set activity
    uint32_t group;              ///< set filter
    uint32_t mask;               ///< set filter
    bool selfCollision;          ///< set self collision
    double margin;               ///< set margin
    /// Detect: the definition. If the recorded one had a filter, this one's rejects the pairs that the filter rejected;
    /// it is valid as long as the operation.
    qcDetectDef detect;
    size_t rejectedPairCount; ///< detect: pairs of bodies that the filter rejected
    /// Detect: the result below was recorded. False: the program ended before the detection did.
    bool hasResult;
    qcStatus resultStatus;   ///< detect: what qcScene_Detect returned
    qcResultHash resultHash; ///< detect: if resultStatus is qc_statusOk
    /// End: the recording was closed by its program. False: the program ended first, or writing failed.
    bool isComplete;
} qcOperation;

/// Reads the next operation; at the end one of kind qc_operationEnd, which can be read again. The operation and its
/// arrays belong to the recording and are valid until the next call. O(its data).
///
/// qc_statusFile: the file is damaged or ends within the operation; the message names the operation and its byte. All
/// operations before it are as they were recorded. No further one can be read. qc_statusOutOfMemory.
QC_API qcStatus qcRecording_Next(qcRecording* recording, const qcOperation** operation);

/// Applies an operation to a scene: see qcOperation::id. `result` (may be null) is set by a detection, which is run as
/// recorded; for another method, device or number of threads call qcScene_Detect with a changed copy of
/// qcOperation::detect. Returns the status of the scene's function; the message names the operation.
QC_API qcStatus qcOperation_Apply(const qcOperation* operation, qcScene* scene, const qcResult** result);

#ifdef __cplusplus
}
#endif

#endif
