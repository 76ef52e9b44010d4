// The method `layers`: from bodies and their pairs to triangle pairs within the query distance, on the device.
#ifndef QC_CULL_LAYERS_LAYERS_H
#define QC_CULL_LAYERS_LAYERS_H

#include "cull/layers/cpu_refine.h"
#include "cull/layers/gpu_residency.h"
#include "cull/layers/grid_resolution.h"
#include "quickcullide/scene.h"

/// Consecutive failures of the device: it is tried again after more and more steps, or at once if the scene is half or
/// double the size of those that failed.
typedef struct qcCullLayersFailures
{
    uint32_t count, waiting;             ///< waiting: steps until the next attempt
    uint64_t minTriangles, maxTriangles; ///< of the steps that failed
    uint32_t generation;                 ///< of the device: a reopened device is tried at once
    char reason[200];                    ///< of the last failure
} qcCullLayersFailures;

/// Retained between steps.
typedef struct qcCullLayers
{
    qcLayers* layers; ///< created at first use
    qcCullLayersFailures failures;
    qcGridFrame frame;
    qcGridSamples gridSamples;
    qcGpuResidency residency;
    qcCpuRefine refine;
    qcArray takesPart, hasSelfPairs; ///< uint8_t, by body of the step
    qcArray partnerBoxes;            ///< uint32_t, four by body: the AABB of its partners in levels
    qcArray partners;                ///< of qcGridBounds, by body: the AABB of its partners
    qcArray bodyOf;                  ///< uint32_t, by slot: body of the step
    qcArray sureBefore;              ///< of qcDevicePairs_Take
    qcLayerTime times[qc_layersPartCount];
} qcCullLayers;

typedef struct qcCullLayersJob
{
    qcDevice* device;
    const qcStepTriangles* triangles;
    const uint8_t* bodies;          ///< by body: a flag, equal for both bodies of a pair; set: pairs are found here
    const uint32_t (*bodyPairs)[2]; ///< the pairs of bodies of the step
    size_t bodyPairCount;
    double queryDistance;
    double margin;       ///< qcDetectDef::margin: pairs proven no further apart are classified near
    bool testNeighbours; ///< triangles of one body that share a vertex are candidates too
    bool listClassified; ///< classified pairs are among the contact keys, too
    uint32_t columns;    ///< 0: chosen
    char depthAxis;      ///< 0: chosen
    bool timed;
    uint32_t threads;
} qcCullLayersJob;

/// Adds keys of pairs, in no order. qc_statusDevice and qc_statusDeviceLost: the device failed, for the reason in the
/// message, and another method must find the pairs.
qcStatus qcCullLayers_Run(const qcCullLayersJob* job, qcCullLayers* cull, const qcPairKeys* keys, qcProfile* profile);

/// Adds the keys of all neighbours of a body whose self pairs were found in the last step.
qcStatus qcCullLayers_ListNeighbours(const qcCullLayers* cull, const qcStepTriangles* triangles, uint32_t body,
                                     qcArray* keys);
void qcCullLayers_Free(qcCullLayers* cull);

#endif
