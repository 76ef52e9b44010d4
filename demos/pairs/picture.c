// The picture of qc-pairs: the meshes in light colours, the potentially colliding set in red.
// After figures 4 and 5 of Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005.
#include "pairs/pairs.h"

#include "common/png_file.h"

#include <math.h>
#include <stdlib.h>

typedef struct Frame
{
    double centre[3];
    double halfSize[3];
    double scale; ///< brings the longest half side to 1
} Frame;

static double GetCoordinate(const qcMesh* mesh, size_t i)
{
    return mesh->isDouble ? ((const double*)mesh->positions)[i] : (double)((const float*)mesh->positions)[i];
}

/// The box around all meshes. Halves first: a sum or difference of two finite numbers may be infinite.
static Frame FindFrame(const qcPairsRun* run)
{
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t m = 0; m < run->options->pathCount; ++m)
    {
        for (size_t i = 0; i < 3 * (size_t)run->meshes[m].vertexCount; ++i)
        {
            double half = 0.5 * GetCoordinate(&run->meshes[m], i);
            lower[i % 3] = fmin(lower[i % 3], half);
            upper[i % 3] = fmax(upper[i % 3], half);
        }
    }
    Frame frame = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1.0};
    double longest = 0.0;
    for (int axis = 0; axis < 3 && lower[0] <= upper[0]; ++axis)
    {
        frame.centre[axis] = lower[axis] + upper[axis];
        frame.halfSize[axis] = upper[axis] - lower[axis];
        longest = fmax(longest, frame.halfSize[axis]);
    }
    // Its inverse must be finite.
    if (longest > 1e-300)
        frame.scale = 1.0 / longest;
    for (int axis = 0; axis < 3; ++axis)
        frame.halfSize[axis] *= frame.scale;
    return frame;
}

static double Dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Views the box from its front, right and above, at the smallest distance that shows all its corners.
static void PlaceEye(const Frame* frame, qcPictureDef* def)
{
    static const double back[3] = {0.48, 0.36, 0.8}; // a unit vector, from the box to the eye
    static const double right[3] = {0.857492925712544, 0.0, -0.514495755427527};
    static const double up[3] = {-0.185218471953910, 0.932952303175248, -0.308697453256516};
    double tangentY = tan(0.5 * def->fieldOfView * 3.14159265358979 / 180.0);
    double tangentX = tangentY * def->width / def->height;
    double distance = 0.0;
    for (int i = 0; i < 8; ++i)
    {
        double corner[3];
        for (int axis = 0; axis < 3; ++axis)
            corner[axis] = (i >> axis & 1 ? 1.0 : -1.0) * frame->halfSize[axis];
        double needed = fmax(fabs(Dot(corner, right)) / tangentX, fabs(Dot(corner, up)) / tangentY);
        distance = fmax(distance, Dot(corner, back) + needed);
    }
    // 1.05: a small border. 0.1: a scene of one point still needs an eye apart from it.
    distance = fmax(1.05 * distance, 0.1);
    for (int axis = 0; axis < 3; ++axis)
    {
        def->target[axis] = 0.0f;
        def->eye[axis] = (float)(distance * back[axis]);
        def->up[axis] = axis == 1 ? 1.0f : 0.0f;
    }
}

static void SetColors(qcPictureMesh* mesh, uint32_t index)
{
    static const float colors[6][3] = {{0.72f, 0.68f, 0.58f}, {0.55f, 0.66f, 0.76f}, {0.60f, 0.73f, 0.57f},
                                       {0.75f, 0.60f, 0.64f}, {0.64f, 0.60f, 0.76f}, {0.76f, 0.71f, 0.45f}};
    static const float red[3] = {0.80f, 0.02f, 0.02f};
    for (int i = 0; i < 3; ++i)
    {
        mesh->color[i] = colors[index % 6][i];
        mesh->backColor[i] = 0.6f * mesh->color[i];
        mesh->markColor[i] = red[i];
    }
}

static bool FillMesh(const qcPairsRun* run, const Frame* frame, uint32_t index, qcPictureMesh* picture)
{
    const qcMesh* mesh = &run->meshes[index];
    size_t count = 3 * (size_t)mesh->vertexCount;
    float* positions = malloc(count * sizeof *positions + 1);
    uint8_t* marked = calloc((size_t)mesh->triangleCount + 1, 1);
    picture->positions = positions;
    picture->marked = marked;
    if (positions == NULL || marked == NULL)
        return false;
    // Subtracted in double: far from the origin a float would lose the shape.
    for (size_t i = 0; i < count; ++i)
        positions[i] = (float)((GetCoordinate(mesh, i) - frame->centre[i % 3]) * frame->scale);
    for (size_t i = 0; i < run->result->pcsCount; ++i)
    {
        if (run->result->pcs[i].body == index)
            marked[run->result->pcs[i].triangle] = 1;
    }
    picture->vertexCount = mesh->vertexCount;
    picture->indices = mesh->indices;
    picture->triangleCount = mesh->triangleCount;
    SetColors(picture, index);
    return true;
}

static qcExitStatus Draw(const qcPairsRun* run, qcPictureMesh* meshes, uint8_t* rgb, qcPictureDef* def,
                         qcMessage* message)
{
    Frame frame = FindFrame(run);
    PlaceEye(&frame, def);
    bool filled = meshes != NULL && rgb != NULL;
    for (uint32_t i = 0; filled && i < def->meshCount; ++i)
        filled = FillMesh(run, &frame, i, &meshes[i]);
    if (!filled)
    {
        qcMessage_Fail(message, "out of memory for the picture");
        return qc_exitFailed;
    }
    qcStatus status = qcDevice_DrawPicture(run->pictureDevice, def, rgb);
    if (status != qc_statusOk)
    {
        qcMessage_Fail(message, "--picture: %s", qcLastMessage());
        return status == qc_statusDevice || status == qc_statusDeviceLost ? qc_exitDevice : qc_exitFailed;
    }
    return qcPng_Write(run->options->picture, def->width, def->height, rgb, message) ? qc_exitDone : qc_exitFailed;
}

qcExitStatus qcPairs_DrawPicture(const qcPairsRun* run, qcMessage* message)
{
    qcPictureDef def = qcDefaultPictureDef();
    def.meshCount = run->options->pathCount;
    qcPictureMesh* meshes = calloc(def.meshCount, sizeof *meshes);
    uint8_t* rgb = malloc((size_t)def.width * def.height * 3);
    def.meshes = meshes;
    qcExitStatus ending = Draw(run, meshes, rgb, &def, message);
    for (uint32_t i = 0; meshes != NULL && i < def.meshCount; ++i)
    {
        free((void*)meshes[i].positions);
        free((void*)meshes[i].marked);
    }
    free(meshes);
    free(rgb);
    return ending;
}
