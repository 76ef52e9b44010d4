// The method `layers`: from bodies and their pairs to triangle pairs that may be within reach, on the device.
#ifndef QC_CULL_LAYERS_LAYERS_H
#define QC_CULL_LAYERS_LAYERS_H

#include "cull/layers/gpu_residency.h"
#include "cull/layers/cpu_refine.h"
#include "quickcullide/scene.h"

/// Failures of the device, one after another: it is tried again after ever more steps.
typedef struct qcCullLayersFailures
{
    uint32_t count, waiting; ///< waiting: steps that are not tried
    uint32_t generation;     ///< of the device: a device that was reopened is tried at once
    char reason[200];        ///< of the last
} qcCullLayersFailures;

typedef struct qcCullLayers
{
    qcLayers* layers; ///< made at first use
    qcCullLayersFailures failures;
    qcLayersFrame frame;
    qcLayersBodies bodies;
    qcLayersRefine refine;
    qcArray takesPart, meetsItself; ///< uint8_t, by body of the step
    qcArray interests;              ///< uint32_t, four by body
    qcArray partners;               ///< of qcLayersView: around the partners of a body
    qcArray numberOf;               ///< uint32_t, by slot: body of the step
    qcLayerTime times[qc_layersPartCount];
} qcCullLayers;

typedef struct qcCullLayersJob
{
    qcDevice* device;
    const qcStepTriangles* triangles;
    const uint8_t* bodies;    ///< by body of the step: whether it is asked about. Whoever meets it is too.
    const uint32_t* meetings; ///< pairs of bodies of the step that may meet: two numbers each
    size_t meetingCount;      ///< pairs
    double reach;
    double nearest;      ///< pairs that are no further apart, as far as their bodies' margins go, are near
    bool testNeighbours; ///< triangles of one body that share a vertex are candidates too
    bool listKnown;      ///< pairs whose relation is known are among the contact keys, too
    uint32_t columns;    ///< 0: chosen
    char depthAxis;      ///< 0: chosen
    bool timed;
    uint32_t threads;
} qcCullLayersJob;

/// Adds keys of pairs, in no order. qc_statusDevice: the device can't, and a method that needs none has to answer; the
/// message says why.
qcStatus qcCullLayers_Run(qcCullLayers* cull, const qcCullLayersJob* job, const qcPairKeys* keys, qcProfile* profile);

/// Adds the keys of all pairs of neighbours of a body that met itself in the last step.
qcStatus qcCullLayers_ListNeighbours(const qcCullLayers* cull, const qcStepTriangles* triangles, uint32_t body,
                                     qcArray* keys);
void qcCullLayers_Free(qcCullLayers* cull);

#endif
