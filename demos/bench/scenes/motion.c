// Motion for the benchmarks: vertices on closed curves whose phase is a wave through space; rigid bodies that sway.
#include "bench/scenes/motion.h"

#include "bench/scenes/shapes.h"
#include "common/mesh_io/bounds.h"

#include <math.h>

static const double s_pi = 3.14159265358979323846;

// Motion in a frame relative to the diagonal: 0.3 %, about that of a cloth's vertex or a falling body in a step.
static const double s_step = 0.003;

qcBenchMotion qcBenchMotion_Make(const qcMesh* bodies, uint32_t bodyCount, uint32_t frameCount)
{
    double lower[3], upper[3], sum = 0.0;
    qcMesh_FindBox(bodies, bodyCount, lower, upper);
    for (int i = 0; i < 3; ++i)
        sum += (upper[i] - lower[i]) * (upper[i] - lower[i]);
    return (qcBenchMotion){sqrt(sum), frameCount};
}

/// The radius of a curve on which each of the frames is a step from the one before.
static double FindRadius(const qcBenchMotion* motion)
{
    return s_step * motion->diagonal / (2.0 * sin(s_pi / motion->frameCount));
}

void qcBenchMotion_Deform(const qcBenchMotion* motion, const qcMesh* body, uint32_t frame, float* positions)
{
    const float* in = body->positions;
    double turn = 2.0 * s_pi * frame / motion->frameCount, radius = FindRadius(motion) / sqrt(1.5);
    // One and a half waves along the diagonal: the motions of neighbours differ by a few hundredths.
    double wave = 3.0 * s_pi / motion->diagonal;
    for (size_t vertex = 0; vertex < body->vertexCount; ++vertex, in += 3, positions += 3)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            double phase = wave * (in[(axis + 1) % 3] + 0.5 * in[(axis + 2) % 3]) + 2.0 * s_pi / 3.0 * axis;
            positions[axis] = (float)(in[axis] + radius * sin(turn + phase));
        }
    }
}

qcTransform qcBenchMotion_Carry(const qcBenchMotion* motion, const qcTransform* place, uint32_t body, uint32_t frame)
{
    uint64_t seed = body;
    double turn = 2.0 * s_pi * frame / motion->frameCount + qcBenchShapes_Random(&seed, 0.0, 2.0 * s_pi);
    // Half of the motion is rotation: a bunny's ears are about its size from its centre.
    double radius = 0.5 * FindRadius(motion), angle = 0.5 * FindRadius(motion) / motion->diagonal * sin(turn);
    int axis = (int)(body % 3), a = (axis + 1) % 3, b = (axis + 2) % 3;
    qcTransform moved = *place;
    double c = cos(angle), s = sin(angle);
    for (int column = 0; column < 3; ++column)
    {
        moved.linear[3 * a + column] = c * place->linear[3 * a + column] - s * place->linear[3 * b + column];
        moved.linear[3 * b + column] = s * place->linear[3 * a + column] + c * place->linear[3 * b + column];
    }
    moved.translation[a] += radius * cos(turn);
    moved.translation[b] += radius * sin(turn);
    return moved;
}
