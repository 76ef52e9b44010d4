// The frame of `layers`: where the image lies in the world, and how coordinates become levels. It stays while the scene
// fits, so that what does not move keeps its place on the device.
#ifndef QC_CULL_LAYERS_FRAME_H
#define QC_CULL_LAYERS_FRAME_H

#include <stdbool.h>
#include <stdint.h>

/// What a frame is asked to hold.
typedef struct qcLayersView
{
    double lower[3], upper[3]; ///< world: around all that takes part
    double reach;              ///< world: how far apart triangles count
    char depthAxis;            ///< 'x', 'y', 'z', or 0: the axis along which the scene is thinnest
    bool transforms;           ///< rigid bodies are transformed in single precision
} qcLayersView;

typedef struct qcLayersFrame
{
    uint64_t number;             ///< grows with each new frame; 0: none yet
    int axes[3];                 ///< world axis of each component; the last is depth
    double origin[3], extent[3]; ///< by component
    int exponent;                ///< one unit of the frame is 2^exponent
    double unit;                 ///< 2^-exponent
    //  What the device needs, see gl/layers.h.
    float scale[3], slack[4], pointError, reach;
    qcLayersView view; ///< the view it was made for
} qcLayersFrame;

/// Keeps the frame if it still suits the view, or makes a new one. False: no frame can hold this (it is too large for
/// doubles); the frame is as before.
bool qcLayersFrame_Fit(qcLayersFrame* frame, const qcLayersView* view);

/// A world position (three doubles) in the frame, in double; within [0, 1] for what the view holds.
static inline void qcLayersFrame_Map(const qcLayersFrame* frame, const double world[3], double inFrame[3])
{
    for (int i = 0; i < 3; i++)
        inFrame[i] = (world[frame->axes[i]] - frame->origin[i]) * frame->unit;
}

/// A world box in levels, rounded outward, with the slack that boxes of triangles have. The diagonal is unbounded.
void qcLayersFrame_MapBox(const qcLayersFrame* frame, const double lower[3], const double upper[3], uint32_t box[4]);

#endif
