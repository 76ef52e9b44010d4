// The grid frame of `layers`: from world coordinates to the grid's levels. A frame is retained while the scene fits
// into it, so that bodies at rest are not uploaded again.
#ifndef QC_CULL_LAYERS_FRAME_H
#define QC_CULL_LAYERS_FRAME_H

#include <stdbool.h>
#include <stdint.h>

/// The bounds and distances that a frame is made for.
typedef struct qcGridBounds
{
    double lower[3], upper[3]; ///< world AABB of the bodies that take part
    double queryDistance;      ///< world
    char depthAxis;            ///< 'x', 'y', 'z', or 0: the axis along which the scene is thinnest
    bool transforms;           ///< rigid bodies are transformed in single precision
} qcGridBounds;

typedef struct qcGridFrame
{
    uint64_t number;             ///< of this frame, from 1; 0: none yet
    int axes[3];                 ///< world axis of each component; the last is depth
    double origin[3], extent[3]; ///< by component
    int exponent;                ///< one unit of the frame is 2^exponent
    double unit;                 ///< 2^-exponent
    //  For the device, in the frame: see gl/layers/layers_gpu.h.
    float scale[3], slack[4], pointError, queryDistance;
    qcGridBounds bounds; ///< for which the frame was made
} qcGridFrame;

/// Makes a new frame unless the present one suits the bounds. False: the bounds are too large for doubles, the frame is
/// as before.
bool qcGridFrame_Fit(qcGridFrame* frame, const qcGridBounds* bounds);

/// A world position in the frame, in double; within [0, 1] inside the bounds.
static inline void qcGridFrame_Map(const qcGridFrame* frame, const double world[3], double inFrame[3])
{
    for (int i = 0; i < 3; i++)
        inFrame[i] = (world[frame->axes[i]] - frame->origin[i]) * frame->unit;
}

/// A world AABB in levels, rounded outward, with the slack of triangles' boxes. The diagonal is unbounded.
void qcGridFrame_MapBox(const qcGridFrame* frame, const double lower[3], const double upper[3], uint32_t box[4]);

#endif
