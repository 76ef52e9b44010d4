// Chooses the grid frame. Slack for rounding: plugin/docs/proofs/layers.md.
#include "cull/layers/frame.h"

#include "base/aabb.h"
#include "gl/layers/layers_gpu.h"

#include <math.h>

enum
{
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_maxExponent = 960
};

/// Whether the frame holds the bounds without wasting most of its levels.
static bool Suits(const qcGridFrame* frame, const qcGridBounds* bounds)
{
    const qcGridBounds* old = &frame->bounds;
    if (frame->number == 0 || old->queryDistance != bounds->queryDistance || old->depthAxis != bounds->depthAxis ||
        old->transforms != bounds->transforms)
        return false;
    double widest = 0.0, frameWidest = 0.0;
    for (int i = 0; i < 3; i++)
    {
        double lower = bounds->lower[frame->axes[i]], upper = bounds->upper[frame->axes[i]];
        if (lower < frame->origin[i] || upper > frame->origin[i] + frame->extent[i])
            return false;
        widest = fmax(widest, upper - lower);
        frameWidest = fmax(frameWidest, frame->extent[i]);
    }
    return widest >= 0.5 * frameWidest;
}

static void ChooseAxes(qcGridFrame* frame, const qcGridBounds* bounds)
{
    int depth = bounds->depthAxis - 'x';
    if (bounds->depthAxis == 0)
    {
        depth = 2;
        for (int axis = 1; axis >= 0; axis--)
            if (bounds->upper[axis] - bounds->lower[axis] < bounds->upper[depth] - bounds->lower[depth])
                depth = axis;
    }
    frame->axes[0] = (depth + 1) % 3;
    frame->axes[1] = (depth + 2) % 3;
    frame->axes[2] = depth;
}

bool qcGridFrame_Fit(qcGridFrame* frame, const qcGridBounds* bounds)
{
    if (Suits(frame, bounds))
        return true;
    double widest = fmax(qcBounds_Widest(bounds->lower, bounds->upper), 0.0);
    double room = widest / 16.0;
    int exponent = 0;
    if (!isfinite(widest + 2.0 * room))
        return false;
    // The extent and its room are at most 1 in the frame.
    if (widest > 0.0)
        frexp(1.125 * widest, &exponent);
    if (exponent > qc_maxExponent || exponent < -qc_maxExponent)
        return false;

    qcGridFrame made = {
        .number = frame->number + 1, .exponent = exponent, .unit = ldexp(1.0, -exponent), .bounds = *bounds};
    ChooseAxes(&made, bounds);
    made.pointError = bounds->transforms ? 0x1p-18f : 0x1p-23f;
    double queryDistance = bounds->queryDistance * made.unit;
    if (!(queryDistance < 1e6))
        return false;
    made.queryDistance = nextafterf((float)queryDistance, INFINITY);
    for (int i = 0; i < 3; i++)
    {
        int axis = made.axes[i];
        made.origin[i] = bounds->lower[axis] - room;
        made.extent[i] = bounds->upper[axis] - bounds->lower[axis] + 2.0 * room;
        // Along a thin axis levels are no finer than the error of coordinates.
        made.scale[i] = (float)((qc_layersLevels - 1) / fmax(made.extent[i] * made.unit, 1.0 / 64.0));
        made.slack[i] =
            (float)((made.pointError + 0x1p-22 + 0.5 * made.queryDistance) * made.scale[i] * 1.0001 + 0x1p-6);
    }
    made.slack[3] = 0.5f * (made.slack[0] + made.slack[1]) * 1.0001f + 0x1p-6f;
    *frame = made;
    return true;
}

static uint32_t ToLevel(double x)
{
    return x <= 1.0 ? 1 : x >= qc_layersLevels ? qc_layersLevels : (uint32_t)x;
}

void qcGridFrame_MapBox(const qcGridFrame* frame, const double lower[3], const double upper[3], uint32_t box[4])
{
    double a[3], b[3];
    qcGridFrame_Map(frame, lower, a);
    qcGridFrame_Map(frame, upper, b);
    uint32_t first[4] = {0}, last[4] = {[3] = qc_layersLevels};
    for (int i = 0; i < 3; i++)
    {
        first[i] = ToLevel(a[i] * frame->scale[i] - frame->slack[i] - 1.0);
        last[i] = ToLevel(b[i] * frame->scale[i] + frame->slack[i] + 1.0);
    }
    qcLayers_PackBox(first, last, box);
}
