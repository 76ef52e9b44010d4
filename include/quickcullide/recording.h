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

#include "boxes.h"
#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

//  ---- writing -------------------------------------------------------------------------------------

/// Records the scene's operations from now on in a new file, which replaces an old one; it begins with the bodies that
/// the scene has. Null ends the recording and closes the file, as does qcScene_Destroy. A recording that runs already
/// is closed first.
///
/// A recording changes nothing else: where a later write fails, memory runs out, or positions can't be read back from
/// the device, it stops with one line to qcSetLog, and the scene goes on. Ended with null, the call then returns
/// qc_statusFile, qc_statusOutOfMemory or qc_statusDevice with the reason. What was written until then can be
/// replayed, and so can the file of a program that crashed.
///
/// Only calls that succeed are recorded, and every qcScene_Detect with a valid definition. A pair filter is not called
/// in a replay; the pairs of bodies that it rejected are recorded. Equal calls give equal bytes.
///
/// qc_statusFile: the file can't be created or written; nothing is recorded. qc_statusOutOfMemory likewise.
/// qc_statusDevice and qc_statusDeviceLost: the device has the only copy of positions (qcScene_SetVertexBuffer) and
/// failed, or lost them; nothing has changed.
/// O(size of the scene); then each operation costs O(its data), and adding a body also O(different sets of indices so
/// far), which is some nanoseconds for a hundred of them.
///
/// QC_RECORD=PREFIX starts it in qcScene_Create. N in PREFIX.N.qcr is the first number that is free: no file is
/// replaced, and several processes write different files. If a file can't be created, that is logged, or written to
/// standard error where there is no log function. After fork() only the parent goes on recording.
QC_API qcStatus qcScene_Record(qcScene* scene, const char* path);

//  ---- writing a broadphase ------------------------------------------------------------------------

/// Writes the calls that a broadphase receives, and what it answered. For authors of broadphases: qcBroadphase records
/// itself (qcBroadphase::record, or QC_RECORD). Any thread.
///
/// Boxes have ids of the caller's choice, unique among those that are there. Between a Begin and its End, functions
/// other than SetFilter are written behind the End: changes by a callback take effect after its query.
/// Failures are those of qcScene_Record: recording stops, and only Close reports it. Each function is O(its arguments).
typedef struct qcBoxRecorder qcBoxRecorder;

/// Creates a file; path null: as QC_RECORD has it, or no recorder (null) if it is not set. `scalarSize`: 4 or 8, the
/// bytes of the broadphase's own numbers, in which bounds are written.
QC_API qcStatus qcBoxRecorder_Open(const char* path, uint32_t scalarSize, qcBoxRecorder** recorder);
/// Ends the recording. The first failure since Open. Null is allowed.
QC_API qcStatus qcBoxRecorder_Close(qcBoxRecorder* recorder);
/// A new box; bounds[0..2] are its lower corner, bounds[3..5] its upper one.
QC_API void qcBoxRecorder_Add(qcBoxRecorder* recorder, uint32_t id, const double bounds[6], uint32_t group,
                              uint32_t mask);
/// A box is gone.
QC_API void qcBoxRecorder_Remove(qcBoxRecorder* recorder, uint32_t id);
/// A box has moved.
QC_API void qcBoxRecorder_Move(qcBoxRecorder* recorder, uint32_t id, const double bounds[6]);
/// A box has another filter. Within a search for pairs: one that the search used already.
QC_API void qcBoxRecorder_SetFilter(qcBoxRecorder* recorder, uint32_t id, uint32_t group, uint32_t mask);
/// All boxes are gone, and the broadphase is as new.
QC_API void qcBoxRecorder_Reset(qcBoxRecorder* recorder);
/// A query, or the search for pairs, begins. Several threads may have one each.
QC_API void qcBoxRecorder_Begin(qcBoxRecorder* recorder);
/// A search for pairs ends. `pairs`: all that overlap and whose filters agree, sorted. `hasCallback`: a filter callback
/// decides in place of groups and masks; `rejected` are the overlapping pairs that it rejected, sorted.
QC_API void qcBoxRecorder_EndPairs(qcBoxRecorder* recorder, const qcBoxPair* pairs, size_t pairCount, bool hasCallback,
                                   const qcBoxPair* rejected, size_t rejectedCount);
/// A query of a box ends; `ids` are the boxes that were reported, sorted.
QC_API void qcBoxRecorder_EndQuery(qcBoxRecorder* recorder, const double bounds[6], const uint32_t* ids, size_t count);

/// A cast as Bullet has it. Coordinates of the moving box are relative to the moving point; zeros cast a ray.
typedef struct qcBoxCast
{
    double from[3];             ///< start of the path
    double to[3];               ///< its end
    double bounds[6];           ///< lower and upper corner of the moving box
    double directionInverse[3]; ///< btBroadphaseRayCallback::m_rayDirectionInverse
    double lambda;              ///< btBroadphaseRayCallback::m_lambda_max at the start
} qcBoxCast;

/// A cast ends; `ids` are the boxes that were reported, in this order, and lambdas[i] is the callback's m_lambda_max
/// after ids[i].
QC_API void qcBoxRecorder_EndCast(qcBoxRecorder* recorder, const qcBoxCast* cast, const uint32_t* ids,
                                  const double* lambdas, size_t count);

/// The hash by which pairs are compared: of their number and order, too. O(count). Any thread.
QC_API uint64_t qcBoxPairs_Hash(const qcBoxPair* pairs, size_t count);

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

/// Hashes a result. O(its size). Any thread, while the result is valid.
QC_API qcResultHash qcResult_Hash(const qcResult* result);

//  ---- reading -------------------------------------------------------------------------------------

/// A recording that is being read. One thread at a time.
///
///     qcStatus status = qcRecording_Open("scene.qcr", &recording);
///     bool ends = false;
///     while (status == qc_statusOk && !ends)
///     {
///         status = qcRecording_Next(recording, &operation);
///         if (status == qc_statusOk)
///             status = qcOperation_Apply(operation, scene, &result);
///         ends = status == qc_statusOk && operation->kind == qc_operationEnd;
///     }
typedef struct qcRecording qcRecording;

/// About a recording.
typedef struct qcRecordingInfo
{
    uint32_t formatVersion;  ///< 1
    uint32_t libraryVersion; ///< qcVersion() of the program that recorded
    /// 0: operations of a scene. 4 or 8: a broadphase's, with numbers of this many bytes.
    uint32_t boxScalarSize;
    const char* device; ///< the scene's GL device, such as "llvmpipe ..."; "none". Valid until the recording is closed
} qcRecordingInfo;

/// Opens a file. qc_statusFile: it can't be read, is no recording, or is of a newer format; the message names the
/// reason. qc_statusOutOfMemory. After a failure the recording is null.
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
    qc_operationDetect = 10,          ///< qcScene_Detect
    qc_operationAddBox = 20,          ///< qcBoxRecorder_Add
    qc_operationRemoveBox = 21,       ///< qcBoxRecorder_Remove
    qc_operationMoveBoxes = 22,       ///< qcBoxRecorder_Move, one call or several
    qc_operationSetBoxFilter = 23,    ///< qcBoxRecorder_SetFilter
    qc_operationResetBoxes = 24,      ///< qcBoxRecorder_Reset
    qc_operationFindPairs = 25,       ///< qcBoxRecorder_EndPairs
    qc_operationQueryBox = 26,        ///< qcBoxRecorder_EndQuery
    qc_operationCastBox = 27          ///< qcBoxRecorder_EndCast
} qcOperationKind;

/// "end", "add body", "remove body" ...; "unknown operation" for other values. Static. O(1). Any thread.
QC_API const char* qcOperationKind_Name(qcOperationKind kind);

/// An operation of a broadphase.
typedef struct qcBoxOperation
{
    const uint32_t* ids;       ///< add, remove, filter: one box; move: several; query, cast: the boxes reported
    size_t count;              ///< number of ids
    const double* bounds;      ///< add, move: six for each box; query: six
    const double* lambdas;     ///< cast: one for each box
    qcBoxCast cast;            ///< cast
    uint32_t group;            ///< add, filter
    uint32_t mask;             ///< add, filter
    size_t pairCount;          ///< find pairs: number of pairs
    uint64_t pairHash;         ///< find pairs: qcBoxPairs_Hash of them
    bool hasCallback;          ///< find pairs: the rejected pairs decide in place of groups and masks
    bool isDisturbed;          ///< find pairs, query, cast: a callback changed the broadphase meanwhile
    const qcBoxPair* rejected; ///< find pairs: overlapping pairs that a callback rejected, sorted
    size_t rejectedCount;      ///< find pairs: number of them
} qcBoxOperation;

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
    qcBoxOperation boxes;    ///< operations of a broadphase
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
