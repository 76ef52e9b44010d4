// Time of a step of moving boxes, against their number and the share that moves.
#include "bench/scaling/scaling.h"

#include "bench/scenes/shapes.h"
#include "common/stopwatch.h"
#include "common/progress.h"

#include <quickcullide/boxes.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum
{
    qc_minSteps = 10,
    qc_maxSteps = 200,
    qc_warmSteps = 3
};

// The time limit of one row.
static const double s_enoughMs = 300.0;

static const uint32_t s_sizes[qc_scalingBoxSizes] = {100,   200,   500,   1000,   2000,  5000,
                                                     10000, 20000, 50000, 100000, 200000};
static const uint32_t s_percents[qc_scalingFractions] = {0, 1, 10, 100};

uint32_t qcScaling_CountBoxSizes(const qcScalingOptions* options)
{
    uint32_t count = 0;
    while (count < qc_scalingBoxSizes && s_sizes[count] <= options->maxBoxes)
        ++count;
    return count;
}

typedef struct Box
{
    double lower[3], upper[3], velocity[3];
    uint32_t id;
} Box;

typedef struct World
{
    qcBoxes* set;
    Box* boxes;
    uint32_t count;
    double side; ///< of the cube that they move in
    const qcBoxPair* pairs;
    size_t pairCount;
} World;

/// Edges of 1 to 2, so dense that each box overlaps four others: two boxes overlap if the distance of their centres is
/// less than half the sum of their edges, 1.5 in the mean, along each axis.
static void Scatter(World* world)
{
    uint64_t seed = world->count;
    world->side = cbrt(world->count * 27.0 / 4.0);
    for (uint32_t i = 0; i < world->count; ++i)
    {
        Box* box = &world->boxes[i];
        for (int axis = 0; axis < 3; ++axis)
        {
            box->lower[axis] = qcBenchShapes_Random(&seed, 0.0, world->side);
            box->upper[axis] = box->lower[axis] + qcBenchShapes_Random(&seed, 1.0, 2.0);
            // About 0.1 a step.
            box->velocity[axis] = qcBenchShapes_Random(&seed, -0.1, 0.1);
        }
    }
}

/// Moves a box along a straight line, reflected at the walls.
static void Drift(const World* world, Box* box)
{
    for (int axis = 0; axis < 3; ++axis)
    {
        double next = box->lower[axis] + box->velocity[axis];
        if (next < 0.0 || next > world->side)
            box->velocity[axis] = -box->velocity[axis];
        box->lower[axis] += box->velocity[axis];
        box->upper[axis] += box->velocity[axis];
    }
}

static qcStatus Fill(World* world)
{
    qcStatus status = qcBoxes_Create(&world->set);
    for (uint32_t i = 0; status == qc_statusOk && i < world->count; ++i)
    {
        Box* box = &world->boxes[i];
        status = qcBoxes_Add(world->set, box->lower, box->upper, NULL, &box->id);
    }
    if (status == qc_statusOk)
        status = qcBoxes_FindMovedPairs(world->set, &world->pairs, &world->pairCount);
    return status;
}

/// The boxes are moved before the clock starts: in a simulation moving them is not the broadphase's work.
static qcStatus Step(World* world, uint32_t moving, double* ms)
{
    for (uint32_t i = 0; i < moving; ++i)
        Drift(world, &world->boxes[i]);
    qcStatus status = qc_statusOk;
    double start = qcStopwatch_NowMs();
    for (uint32_t i = 0; status == qc_statusOk && i < moving; ++i)
        status = qcBoxes_Move(world->set, world->boxes[i].id, world->boxes[i].lower, world->boxes[i].upper);
    if (status == qc_statusOk)
        status = qcBoxes_FindMovedPairs(world->set, &world->pairs, &world->pairCount);
    *ms = qcStopwatch_NowMs() - start;
    return status;
}

static qcStatus Time(World* world, qcScalingBoxRow* row)
{
    double times[qc_maxSteps], ms, spent = 0.0;
    qcStatus status = qc_statusOk;
    for (int i = 0; status == qc_statusOk && i < qc_warmSteps; ++i)
        status = Step(world, row->moving, &ms);
    while (status == qc_statusOk && (row->steps < qc_minSteps || (row->steps < qc_maxSteps && spent < s_enoughMs)))
    {
        status = Step(world, row->moving, &times[row->steps]);
        spent += times[row->steps++];
    }
    row->ms = qcStopwatch_Median(times, row->steps);
    row->minMs = times[0];
    return status;
}

static qcStatus MeasureRow(World* world, qcScalingBoxRow* row)
{
    size_t before = qcGetByteCount();
    Scatter(world);
    double start = qcStopwatch_NowMs();
    qcStatus status = Fill(world);
    row->addMs = qcStopwatch_NowMs() - start;
    if (status == qc_statusOk)
        status = Time(world, row);
    row->bytes = (double)(qcGetByteCount() - before) / row->boxes;
    row->pairs = world->pairCount;
    qcBoxes_Destroy(world->set);
    world->set = NULL;
    return status;
}

bool qcScaling_MeasureBoxes(uint32_t size, qcScalingBoxRow rows[qc_scalingFractions], qcMessage* message)
{
    World world = {.count = s_sizes[size], .boxes = calloc(s_sizes[size], sizeof *world.boxes)};
    char label[64];
    snprintf(label, sizeof label, "%u boxes", world.count);
    if (world.boxes == NULL)
        return qcMessage_Fail(message, "out of memory");
    qcProgress_Begin(qc_scalingFractions, label);
    qcStatus status = qc_statusOk;
    for (uint32_t i = 0; status == qc_statusOk && i < qc_scalingFractions; ++i)
    {
        uint32_t moving = (uint32_t)((uint64_t)world.count * s_percents[i] / 100);
        rows[i] = (qcScalingBoxRow){.boxes = world.count, .percent = s_percents[i], .moving = moving};
        status = MeasureRow(&world, &rows[i]);
        qcProgress_Update(i + 1);
    }
    qcProgress_End();
    free(world.boxes);
    return status == qc_statusOk || qcMessage_Fail(message, "%u boxes: %s", world.count, qcLastMessage());
}
