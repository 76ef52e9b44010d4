// Choice of the frame. Rounding: gl/layers.c says how large the slack has to be, and why.
#include "cull/layers/frame.h"

#include "gl/layers/layers_gpu.h"

#include <math.h>
#include <string.h>

enum
{
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_largestExponent = 960
};

/// Does the frame hold the view without wasting most of its levels?
static bool Suits(const qcLayersFrame* frame, const qcLayersView* view)
{
    const qcLayersView* old = &frame->view;
    if (frame->number == 0 || old->reach != view->reach || old->depthAxis != view->depthAxis ||
        old->transforms != view->transforms)
        return false;
    double widest = 0.0, frameWidest = 0.0;
    for (int i = 0; i < 3; i++)
    {
        double lower = view->lower[frame->axes[i]], upper = view->upper[frame->axes[i]];
        if (lower < frame->origin[i] || upper > frame->origin[i] + frame->extent[i])
            return false;
        widest = fmax(widest, upper - lower);
        frameWidest = fmax(frameWidest, frame->extent[i]);
    }
    return widest >= 0.5 * frameWidest;
}

static void ChooseAxes(qcLayersFrame* frame, const qcLayersView* view)
{
    int depth = view->depthAxis - 'x';
    if (view->depthAxis == 0)
    {
        depth = 2;
        for (int axis = 1; axis >= 0; axis--)
            if (view->upper[axis] - view->lower[axis] < view->upper[depth] - view->lower[depth])
                depth = axis;
    }
    frame->axes[0] = (depth + 1) % 3;
    frame->axes[1] = (depth + 2) % 3;
    frame->axes[2] = depth;
}

bool qcLayersFrame_Fit(qcLayersFrame* frame, const qcLayersView* view)
{
    if (Suits(frame, view))
        return true;
    double widest = 0.0;
    for (int axis = 0; axis < 3; axis++)
        widest = fmax(widest, view->upper[axis] - view->lower[axis]);
    double room = widest / 16.0;
    int exponent = 0;
    if (!isfinite(widest + 2.0 * room))
        return false;
    // The extent and its room are at most 1 in the frame.
    if (widest > 0.0)
        frexp(1.125 * widest, &exponent);
    if (exponent > qc_largestExponent || exponent < -qc_largestExponent)
        return false;

    qcLayersFrame made = {
        .number = frame->number + 1, .exponent = exponent, .unit = ldexp(1.0, -exponent), .view = *view};
    ChooseAxes(&made, view);
    made.pointError = view->transforms ? 0x1p-18f : 0x1p-23f;
    double reach = view->reach * made.unit;
    if (!(reach < 1e6))
        return false;
    made.reach = nextafterf((float)reach, INFINITY);
    for (int i = 0; i < 3; i++)
    {
        int axis = made.axes[i];
        made.origin[i] = view->lower[axis] - room;
        made.extent[i] = view->upper[axis] - view->lower[axis] + 2.0 * room;
        // A thin axis doesn't get levels finer than coordinates are exact.
        made.scale[i] = (float)((qc_layersLevels - 1) / fmax(made.extent[i] * made.unit, 1.0 / 64.0));
        made.slack[i] = (float)((made.pointError + 0x1p-22 + 0.5 * made.reach) * made.scale[i] * 1.0001 + 0x1p-6);
    }
    made.slack[3] = 0.5f * (made.slack[0] + made.slack[1]) * 1.0001f + 0x1p-6f;
    *frame = made;
    return true;
}

static uint32_t ToLevel(double x)
{
    return x <= 1.0 ? 1 : x >= qc_layersLevels ? qc_layersLevels : (uint32_t)x;
}

void qcLayersFrame_MapBox(const qcLayersFrame* frame, const double lower[3], const double upper[3], uint32_t box[4])
{
    double a[3], b[3];
    qcLayersFrame_Map(frame, lower, a);
    qcLayersFrame_Map(frame, upper, b);
    uint32_t least[4] = {0}, most[4] = {[3] = qc_layersLevels};
    for (int i = 0; i < 3; i++)
    {
        least[i] = ToLevel(a[i] * frame->scale[i] - frame->slack[i] - 1.0);
        most[i] = ToLevel(b[i] * frame->scale[i] + frame->slack[i] + 1.0);
    }
    qcLayers_PackBox(least, most, box);
}
