// The eye, the light and the ground of a picture as matrices.
#include "gl/picture/picture_space.h"

#include "base/status.h"

#include <math.h>

static double Dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float DotF(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void Cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

/// False for a vector without length.
static bool Normalize(double v[3])
{
    double length = sqrt(Dot(v, v));
    if (!(length > 0.0) || !isfinite(length))
        return false;
    for (int i = 0; i < 3; ++i)
        v[i] /= length;
    return true;
}

static void ToFloat(const double v[3], double factor, float result[3])
{
    for (int i = 0; i < 3; ++i)
        result[i] = (float)(factor * v[i]);
}

static void PlaceLight(const qcPictureDef* def, const double forward[3], const double right[3], const double up[3],
                       qcPictureSpace* space)
{
    double light[3] = {def->light[0], def->light[1], def->light[2]};
    if (!Normalize(light))
    {
        for (int i = 0; i < 3; ++i)
            light[i] = up[i] - 0.45 * forward[i] - 0.65 * right[i];
        Normalize(light);
    }
    ToFloat(light, 1.0, space->light);
}

/// `toTarget`: from the eye.
static void PlaceGround(const qcPictureDef* def, const double toTarget[3], const double right[3], const double up[3],
                        qcPictureSpace* space)
{
    double height = ((double)def->groundHeight - Dot(up, space->eye)) / space->unit;
    space->hasGround = def->hasGround && height < 0.0;
    if (!space->hasGround)
        return;
    double extent = def->groundExtent > 0.0f ? (double)def->groundExtent / space->unit : 8.0;
    double across[3], along[3], middle[3];
    Cross(right, up, across);
    Cross(up, across, along);
    Normalize(across);
    Normalize(along);
    double lift = height - Dot(up, toTarget) / space->unit;
    for (int i = 0; i < 3; ++i)
    {
        middle[i] = toTarget[i] / space->unit + lift * up[i];
        space->tileCorner[i] = (float)(((double)def->groundHeight * up[i] - space->eye[i]) / space->unit);
        for (int corner = 0; corner < 4; ++corner)
            space->groundCorners[corner][i] =
                (float)(middle[i] + extent * ((corner == 1 || corner == 2 ? 1.0 : -1.0) * along[i] +
                                              (corner >= 2 ? 1.0 : -1.0) * across[i]));
    }
    ToFloat(middle, 1.0, space->groundMiddle);
    space->groundExtent = (float)extent;
    space->tileWidth = (float)((double)def->groundTile / space->unit);
}

qcStatus qcPictureSpace_Place(const qcPictureDef* def, qcPictureSpace* space)
{
    double toTarget[3], forward[3], right[3], down[3];
    double up[3] = {def->up[0], def->up[1], def->up[2]};
    for (int i = 0; i < 3; ++i)
    {
        space->eye[i] = def->eye[i];
        forward[i] = toTarget[i] = (double)def->target[i] - (double)def->eye[i];
    }
    if (!Normalize(forward))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: eye and target are the same point");
    if (!Normalize(up))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: up has no length");
    Cross(forward, up, right);
    // 1e-4: closer to the line of sight than this, rounding dominates the camera's orientation.
    if (!(Dot(right, right) > 1e-8))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: up is along the line of sight");
    Normalize(right);
    Cross(forward, right, down);

    double tangent = tan((double)def->fieldOfView * 0.00872664625997165);
    space->unit = tangent * Dot(toTarget, forward);
    ToFloat(up, 1.0, space->up);
    ToFloat(forward, 1.0, space->forward);
    ToFloat(right, tangent * def->width / def->height, space->rayX);
    ToFloat(down, tangent, space->rayY);
    PlaceLight(def, forward, right, up, space);
    PlaceGround(def, toTarget, right, up, space);
    return qc_statusOk;
}

/// The smallest depth at which a corner of the picture shows the ground.
static float NearestGround(const qcPictureSpace* space)
{
    float nearest = INFINITY;
    float height = DotF(space->up, space->groundMiddle);
    for (int corner = 0; corner < 4; ++corner)
    {
        float slope = 0.0f; // of the ray through the corner, a depth of 1
        for (int i = 0; i < 3; ++i)
            slope += space->up[i] * (space->forward[i] + (corner & 1 ? 1.0f : -1.0f) * space->rayX[i] +
                                     (corner & 2 ? 1.0f : -1.0f) * space->rayY[i]);
        if (slope < 0.0f)
            nearest = fminf(nearest, height / slope);
    }
    return nearest;
}

static void FitEye(qcPictureSpace* space, float low, float high)
{
    if (space->hasGround)
    {
        low = fminf(low, NearestGround(space));
        for (int corner = 0; corner < 4; ++corner)
            high = fmaxf(high, DotF(space->groundCorners[corner], space->forward));
    }
    float farthest = high > 0.0f ? 1.01f * high : 1.0f;
    // 1/5000: a depth buffer of 24 bits still separates layers at a distance of 1/1000 of the scene.
    float closest = farthest / 5000.0f;
    float nearest = 0.99f * low > closest && low <= high ? 0.99f * low : closest;
    float a = (farthest + nearest) / (farthest - nearest), b = -2.0f * farthest * nearest / (farthest - nearest);
    space->projection[0] = a;
    space->projection[1] = b;
    float xx = DotF(space->rayX, space->rayX), yy = DotF(space->rayY, space->rayY);
    space->clipScale[0] = 1.0f / sqrtf(xx);
    space->clipScale[1] = 1.0f / sqrtf(yy);
    for (int i = 0; i < 3; ++i)
    {
        space->clip[4 * i + 0] = space->rayX[i] / xx;
        space->clip[4 * i + 1] = space->rayY[i] / yy;
        space->clip[4 * i + 2] = a * space->forward[i];
        space->clip[4 * i + 3] = space->forward[i];
    }
    space->clip[12] = space->clip[13] = space->clip[15] = 0.0f;
    space->clip[14] = b;
}

/// Axes of the shadow map: two across the light, and the direction that light takes.
static void LightAxes(const qcPictureSpace* space, float axes[3][3])
{
    double light[3] = {space->light[0], space->light[1], space->light[2]};
    double side[3] = {fabs(light[0]) < 0.6 ? 1.0 : 0.0, fabs(light[0]) < 0.6 ? 0.0 : 1.0, 0.0};
    double x[3], y[3];
    Cross(side, light, x);
    Normalize(x);
    Cross(light, x, y);
    ToFloat(x, 1.0, axes[0]);
    ToFloat(y, 1.0, axes[1]);
    ToFloat(light, -1.0, axes[2]);
}

/// `lower` and `upper` bound all vertices along the axes.
static void FitLight(qcPictureSpace* space, float axes[3][3], const float lower[3], const float upper[3])
{
    // What is farther than this from the target casts no shadow into the picture: the map keeps its resolution.
    const float reach = 8.0f;
    for (int axis = 0; axis < 3; ++axis)
    {
        float low = lower[axis], high = upper[axis];
        if (axis < 2)
        {
            float target = DotF(axes[axis], space->forward) / sqrtf(DotF(space->rayY, space->rayY));
            low = fmaxf(low, target - reach);
            high = fminf(high, target + reach);
        }
        // No mesh, or all of it elsewhere, or flat.
        low = low < high ? low : high - 1.0f;
        low = isfinite(low) && isfinite(high) ? low : 0.0f;
        high = isfinite(high) ? high : 1.0f;
        float border = fmaxf(0.01f * (high - low), 1e-3f);
        low -= border;
        high += border;
        float size = high - low;
        space->lightExtents[axis] = size;
        for (int i = 0; i < 3; ++i)
        {
            space->lightMap[4 * i + axis] = axes[axis][i] / size;
            space->lightClip[4 * i + axis] = 2.0f * axes[axis][i] / size;
            space->lightMap[4 * i + 3] = space->lightClip[4 * i + 3] = 0.0f;
        }
        space->lightMap[12 + axis] = -low / size;
        space->lightClip[12 + axis] = -2.0f * low / size - 1.0f;
    }
    space->lightMap[15] = space->lightClip[15] = 1.0f;
}

void qcPictureSpace_Fit(qcPictureSpace* space, const float* positions, size_t count, size_t stride)
{
    float axes[3][3], lower[3], upper[3], low = INFINITY, high = 0.0f;
    LightAxes(space, axes);
    for (int axis = 0; axis < 3; ++axis)
    {
        lower[axis] = INFINITY;
        upper[axis] = -INFINITY;
    }
    for (size_t i = 0; i < count; ++i)
    {
        const float* p = positions + stride * i;
        float depth = DotF(p, space->forward);
        low = fminf(low, depth);
        high = fmaxf(high, depth);
        for (int axis = 0; axis < 3; ++axis)
        {
            float along = DotF(p, axes[axis]);
            lower[axis] = fminf(lower[axis], along);
            upper[axis] = fmaxf(upper[axis], along);
        }
    }
    FitEye(space, low, high);
    FitLight(space, axes, lower, upper);
}
