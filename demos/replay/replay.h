// Types and functions of qc-replay.
#ifndef QC_DEMOS_REPLAY_REPLAY_H
#define QC_DEMOS_REPLAY_REPLAY_H

#include "common/exit_status.h"
#include "common/message.h"

#include <quickcullide/quickcullide.h>

#include <stdio.h>

enum
{
    qc_recordedMethod = 100,         ///< in place of a qcMethod: the method of each recorded detection
    qc_recordedThreads = UINT32_MAX, ///< likewise
    qc_maxThreads = 1024
};

typedef struct qcReplayOptions
{
    const char* path;
    int method; ///< a qcMethod or qc_recordedMethod
    const char* methodName;
    qcDeviceKind device;
    const char* deviceName; ///< on the command line, or null
    uint32_t threads;       ///< or qc_recordedThreads
    uint32_t from, to;      ///< detections, from 1
    const char* csv;        ///< or null
    bool each, list;
} qcReplayOptions;

/// How a replayed detection compares with the recorded one.
typedef enum qcVerdict
{
    qc_verdictSame,
    qc_verdictDiffers,
    qc_verdictMissed,     ///< a method that samples: some pairs are missed
    qc_verdictNoneMissed, ///< a method that samples, and no pair is missed
    qc_verdictNotCompared ///< the recorded result is missing, or of a method that samples
} qcVerdict;

typedef struct qcDetection
{
    uint64_t number, operation; ///< detections count from 1, operations from 0
    qcMethod method;            ///< that ran
    const char* fallback;       ///< see qcProfile
    double ms;
    uint64_t pairs, contacts, points;
    uint64_t recordedPairs, missed;
    qcVerdict verdict;
    char reason[256]; ///< the fields that differ, or why nothing was compared
} qcDetection;

typedef struct qcReplayTotals
{
    uint64_t operations, detections, same, differing, notCompared;
    uint64_t sampled, missedPairs, exactPairs; ///< of methods that sample
    uint64_t pairs;
    double* times; ///< milliseconds of each replayed detection
    size_t timeCount, timeCapacity;
    bool isComplete, isInterrupted;
    const char* fallback; ///< of the last detection that fell back
} qcReplayTotals;

/// Reads the command line; ends the program after --help and on a mistake.
void qcReplay_ReadOptions(int argumentCount, char** arguments, qcReplayOptions* options);

/// Receives each replayed detection.
typedef void qcDetectionFunction(const qcDetection* detection, void* context);

/// Applies the operations, runs the detections in options->from..to. Also after a failure the totals are those of what
/// was replayed.
qcExitStatus qcReplay_Run(const qcReplayOptions* options, qcRecording* recording, qcDevice* device,
                          qcDetectionFunction* function, void* context, qcReplayTotals* totals, qcMessage* message);

/// Prints each operation on a line.
qcExitStatus qcReplay_List(const qcReplayOptions* options, qcRecording* recording, qcMessage* message);

void qcReplay_PrintHeading(const qcReplayOptions* options, const qcRecording* recording, const qcDevice* device);
/// The head of --each, and its lines.
void qcReplay_PrintColumns(void);
void qcReplay_PrintDetection(const qcDetection* detection);
/// Sorts the times.
void qcReplay_PrintTotals(const qcReplayOptions* options, qcReplayTotals* totals);
void qcReplay_WriteCsvHead(FILE* stream);
void qcReplay_WriteCsvLine(FILE* stream, const qcDetection* detection);

#endif
