// Recordings frame by frame: a frame is all operations up to a detection.
#ifndef QC_DEMOS_BENCH_PAPER_REPLAY_H
#define QC_DEMOS_BENCH_PAPER_REPLAY_H

#include "bench/paper/soup.h"
#include "common/message.h"

#include <quickcullide/quickcullide.h>

typedef struct qcPaperRecordingInfo
{
    uint32_t frameCount;
    uint32_t bodyCount, triangleCount; ///< the maximum of all frames
    char views[4];                     ///< of the last detection
    bool isOneSoup;                    ///< in the first frame most triangles belong to bodies with self-collision
} qcPaperRecordingInfo;

/// Reads the whole file.
bool qcPaperRecording_Inspect(const char* path, qcPaperRecordingInfo* info, qcMessage* message);

typedef struct qcPaperReplay
{
    const char* path;
    qcRecording* recording;
    qcScene* scene;
    qcPaperSoup* soup;            ///< follows the bodies too; may be null
    const qcOperation* detection; ///< that ends the frame; valid until the next frame
    double moveMs;                ///< the operations of this frame, in the scene
    uint32_t frame;               ///< from 0
    uint32_t nextFrame;
    uint32_t frameLimit; ///< the file has changed if it has more frames; 0: none
} qcPaperReplay;

/// Opens a recording, and a scene on the device (null: none). Close it in any case.
bool qcPaperReplay_Open(const char* path, qcDevice* device, qcPaperReplay* replay, qcMessage* message);
/// Applies the operations of the next frame but its detection. `more` is false at the end.
bool qcPaperReplay_Next(qcPaperReplay* replay, bool* more, qcMessage* message);
/// Detects in the current frame: penetrating pairs only. `ms` is the time of the frame, its moves included.
bool qcPaperReplay_Detect(qcPaperReplay* replay, const qcDetectDef* def, const qcResult** result, double* ms,
                          qcMessage* message);
/// The recorded definition without all but the pairs.
qcDetectDef qcPaperReplay_PlainDef(const qcPaperReplay* replay);
void qcPaperReplay_Close(qcPaperReplay* replay);

#endif
