// Scenes for core_hashes.c: seeded soups, closed meshes and cloth that move step by step.
#ifndef QC_GOLDEN_CORE_WORLDS_H
#define QC_GOLDEN_CORE_WORLDS_H

#include "house/golden/meshes.h"

#include "quickcullide/quickcullide.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK_OK(call)                                                                                                 \
    do                                                                                                                 \
    {                                                                                                                  \
        if ((call) != qc_statusOk)                                                                                     \
        {                                                                                                              \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, qcLastMessage());                                       \
            exit(2);                                                                                                   \
        }                                                                                                              \
    } while (0)

//  ---- worlds ------------------------------------------------------------------------------------------------------

enum
{
    qc_maxBodies = 160
};

/// A scene and the meshes of its bodies.
typedef struct World
{
    qcScene* scene;
    qcRandom random;
    qcMesh meshes[qc_maxBodies];
    qcBodyId ids[qc_maxBodies];
    double places[qc_maxBodies][3];
    uint32_t count;
} World;

/// Adds a body; the world takes the mesh over.
static uint32_t AddBody(World* world, qcMesh mesh, bool deforming, qcActivity activity)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh.positions;
    def.positionType = qc_positionF64;
    def.vertexCount = mesh.vertexCount;
    def.indices = mesh.indices;
    def.triangleCount = mesh.triangleCount;
    def.deforming = deforming;
    def.activity = activity;
    uint32_t body = world->count++;
    world->meshes[body] = mesh;
    CHECK_OK(qcScene_AddBody(world->scene, &def, &world->ids[body]));
    return body;
}

/// Removes a body; the last body takes its position in the list.
static void RemoveBody(World* world, uint32_t body)
{
    CHECK_OK(qcScene_RemoveBody(world->scene, world->ids[body]));
    qcMesh_Free(&world->meshes[body]);
    uint32_t last = --world->count;
    world->meshes[body] = world->meshes[last];
    world->ids[body] = world->ids[last];
    memcpy(world->places[body], world->places[last], sizeof world->places[body]);
}

/// Sets a body's positions, as floats in odd steps.
static void SetVertices(World* world, uint32_t body, uint32_t step)
{
    const qcMesh* mesh = &world->meshes[body];
    if (step % 2 == 0)
    {
        CHECK_OK(qcScene_SetVertices(world->scene, world->ids[body], mesh->positions, qc_positionF64, 0));
        return;
    }
    float* floats = malloc(3 * mesh->vertexCount * sizeof(float));
    for (uint32_t i = 0; i < 3 * mesh->vertexCount; i++)
        floats[i] = (float)mesh->positions[i];
    CHECK_OK(qcScene_SetVertices(world->scene, world->ids[body], floats, qc_positionF32, 0));
    free(floats);
}

/// Turns a body by up to `turn` quarters about two axes, then moves it.
static void Place(World* world, uint32_t body, double turn, double x, double y, double z)
{
    double c, s, d, t;
    qcGetCirclePoint(qcRandom_Uniform(&world->random, 0.0, turn), &c, &s);
    qcGetCirclePoint(qcRandom_Uniform(&world->random, 0.0, turn), &d, &t);
    qcTransform transform = {{c, -s, 0, d * s, d * c, -t, t * s, t * c, d}, {x, y, z}};
    CHECK_OK(qcScene_SetTransform(world->scene, world->ids[body], &transform));
}

/// Soups: rigid and turning, one deforming; bodies come and go, filters and activities change.
static void StepSoups(World* world, uint32_t step)
{
    qcRandom* random = &world->random;
    for (uint32_t i = 0; i < 5 && step == 0; i++)
        AddBody(world, qcMesh_MakeSoup(random, 60 + 40 * i, 0.1, 0), i == 4, qc_activityMoving);
    if (step == 2)
    {
        RemoveBody(world, 1);
        AddBody(world, qcMesh_MakeSoup(random, 90, 0.2, 0), true, qc_activityMoving);
        CHECK_OK(qcScene_SetFilter(world->scene, world->ids[2], 2, 0xfffffffeu));
    }
    if (step == 3)
    {
        CHECK_OK(qcScene_SetActivity(world->scene, world->ids[0], qc_activitySleeping));
        CHECK_OK(qcScene_SetActivity(world->scene, world->ids[2], qc_activityStatic));
        CHECK_OK(qcScene_SetSelfCollision(world->scene, world->ids[3], false));
        CHECK_OK(qcScene_SetMargin(world->scene, world->ids[0], 0.001));
    }
    qcMesh_Shake(&world->meshes[4], random, 0.05, 2);
    SetVertices(world, 4, step);
    Place(world, step % 4 == 1 ? 2 : 0, 4.0, 0.1 * step, 0.2, 0.05);
}

static void StepDegenerate(World* world, uint32_t step)
{
    for (uint32_t i = 0; i < 3 && step == 0; i++)
    {
        qcMesh mesh = qcMesh_MakeSoup(&world->random, 130, 0.2, i == 0 ? 0 : 6);
        qcMesh_MakeDegenerate(&world->random, &mesh);
        AddBody(world, mesh, i == 2, qc_activityMoving);
    }
    qcMesh_Move(&world->meshes[2], 1.0, 1.0 / 6.0, 0.0, step == 3 ? 0x1p-30 : 0.0);
    SetVertices(world, 2, 0);
    Place(world, 0, step < 3 ? 0.0 : 4.0, 0.0, 0.25 * step, 0.0);
}

/// A scene so far from the origin that a double resolves 2^-22, and a float 2^7, of the meshes' length.
static void StepFar(World* world, uint32_t step)
{
    for (uint32_t i = 0; i < 4 && step == 0; i++)
    {
        qcMesh mesh =
            i < 2 ? qcMesh_MakeSoup(&world->random, 120, 0.15, i == 0 ? 0 : 8) : qcMesh_MakeTorus(0.5, 0.2, 16, 8);
        qcMesh_Move(&mesh, 1.0, 0x1p30, -0x1p31, 0x1p29 + 0.3 * i);
        AddBody(world, mesh, i == 3, qc_activityMoving);
    }
    qcMesh_Move(&world->meshes[3], 1.0, 0.0, 0.03125, 0.0);
    SetVertices(world, 3, 0);
    Place(world, 1, 0.0, 0.1 * step, 0.0, 0.2);
}

/// Tori and balls through each other.
static void StepClosed(World* world, uint32_t step)
{
    for (uint32_t i = 0; i < 8 && step == 0; i++)
        AddBody(world, i % 2 == 0 ? qcMesh_MakeTorus(0.5, 0.15, 24, 10) : qcMesh_MakeBox(0.4, 5, i != 7), false,
                qc_activityMoving);
    for (uint32_t i = 0; i < world->count && step < 5; i++)
        if (step == 0 || i % 2 == step % 2)
            Place(world, i, step == 0 ? 4.0 : 0.1, 0.3 * (i % 3), 0.35 * (i / 3) - 0.01 * step, 0.2 * (i % 2));
}

/// Boxes and balls in stacks on a static floor: touching, a little apart, a little inside.
static void StepRest(World* world, uint32_t step)
{
    const double gaps[4] = {0.0, 0.004, -0.004, 0.02};
    if (step == 0)
    {
        qcMesh floor = qcMesh_MakeGrid(12, 12, false, false);
        for (uint32_t v = 0; v < floor.vertexCount; v++)
        {
            double* x = floor.positions + 3 * v;
            x[0] = 0.5 * (v % 13) - 1.0, x[1] = 0.5 * (v / 13) - 1.0, x[2] = 0.0;
        }
        AddBody(world, floor, false, qc_activityStatic);
        for (uint32_t i = 0; i < 18; i++)
            AddBody(world, qcMesh_MakeBox(0.25, i % 5 == 4 ? 4 : 2, i % 5 == 4), false, qc_activityMoving);
    }
    for (uint32_t i = 1; i < world->count && step < 5; i++)
    {
        uint32_t high = (i - 1) / 9;
        double gap = gaps[(i + step / 2) % 4];
        if (step == 0 || i % 3 == 0)
            Place(world, i, i % 7 == 0 && step > 2 ? 0.01 : 0.0, 0.55 * (i % 3) + 0.05 * high, 0.6 * (i / 3 % 3),
                  0.25 + 0.5 * high + gap * (high + 1));
    }
}

/// Many small bodies that fall; some go, others come.
static void StepMany(World* world, uint32_t step)
{
    for (uint32_t i = 0; i < 70 && step == 0; i++)
        AddBody(world, i % 3 == 0 ? qcMesh_MakeTorus(0.07, 0.02, 10, 5) : qcMesh_MakeBox(0.05, 2, i % 3 == 1), false,
                i % 10 == 9 ? qc_activitySleeping : qc_activityMoving);
    for (uint32_t i = 0; i < 10 && step == 3; i++)
        RemoveBody(world, 5 * i);
    for (uint32_t i = 0; i < 5 && step == 4; i++)
    {
        uint32_t body = AddBody(world, qcMesh_MakeTorus(0.1, 0.05, 12, 6), false, qc_activityMoving);
        memcpy(world->places[body], world->places[i], sizeof world->places[body]);
    }
    for (uint32_t i = 0; i < world->count; i++)
        for (int axis = 0; axis < 3 && step == 0; axis++)
            world->places[i][axis] = qcRandom_Uniform(&world->random, 0.0, axis == 2 ? 1.0 : 0.9);
    for (uint32_t i = 0; i < world->count; i++)
    {
        if (step > 0 && i % 2 == step % 2)
            continue;
        double* at = world->places[i];
        at[2] *= 0.95;
        Place(world, i, 0.5, at[0], at[1], at[2]);
    }
}

/// A cloth in folds: waits, shakes as a whole, shakes in few places.
static void StepFolded(World* world, uint32_t step)
{
    uint32_t side = 48;
    if (step == 0)
    {
        qcMesh mesh = qcMesh_MakeGrid(side, side, false, false);
        qcMesh_Fold(&mesh, side, 0.02, 0.011, &world->random);
        AddBody(world, mesh, true, qc_activityMoving);
    }
    if (step == 1 || step == 4)
        qcMesh_Shake(&world->meshes[0], &world->random, 0.001, 1);
    if (step == 2)
        qcMesh_Shake(&world->meshes[0], &world->random, 0.0001, 37);
    if (step != 3)
        SetVertices(world, 0, 0);
}

static void StepTwisted(World* world, uint32_t step)
{
    uint32_t side = 28;
    if (step == 0)
    {
        qcMesh mesh = qcMesh_MakeGrid(side, side, false, false);
        qcMesh_Twist(&mesh, side, 3.0, &world->random);
        AddBody(world, mesh, true, qc_activityMoving);
    }
    qcMesh_Twist(&world->meshes[0], side, 3.0 + 0.5 * step, &world->random);
    SetVertices(world, 0, step);
}

/// Two crumpled cloths that penetrate each other; later the second one is replaced by another mesh.
static void StepTangled(World* world, uint32_t step)
{
    const uint32_t sides[2] = {20, 24};
    if (step == 3)
        RemoveBody(world, 1);
    while (world->count < 2)
    {
        uint32_t side = sides[(step == 3) ^ (world->count == 1)];
        qcMesh mesh = qcMesh_MakeGrid(side, side, false, false);
        qcMesh_Fold(&mesh, side, 0.05, 0.04, &world->random);
        if (world->count == 1)
            qcMesh_Twist(&mesh, side, 3.0, &world->random);
        AddBody(world, mesh, true, qc_activityMoving);
    }
    for (uint32_t i = 0; i < 2; i++)
    {
        qcMesh_Shake(&world->meshes[i], &world->random, 0.004, 1 + step % 2);
        SetVertices(world, i, step);
    }
}

/// Sheets one over the other, that slide and come nearer.
static void StepSheets(World* world, uint32_t step)
{
    for (uint32_t i = 0; i < 6 && step == 0; i++)
    {
        uint32_t side = 14;
        qcMesh mesh = qcMesh_MakeGrid(side, side, false, false);
        for (uint32_t v = 0; v < mesh.vertexCount; v++)
        {
            double* x = mesh.positions + 3 * v;
            x[0] = (double)(v % (side + 1)) / side + 0.01 * i, x[1] = (double)(v / (side + 1)) / side;
            x[2] = 0.01 * i + (i % 2 == 0 ? 0.0 : x[0] * x[0] / 32.0);
        }
        AddBody(world, mesh, i % 3 != 0, qc_activityMoving);
    }
    for (uint32_t i = 0; i < 6; i++)
        if (i % 3 == 0)
            Place(world, i, 0.0, 0.002 * step, 0.0, 0.001 * step);
        else
        {
            qcMesh_Move(&world->meshes[i], 1.0, -0.003, 0.001, -0.0005 * i);
            SetVertices(world, i, step);
        }
}

/// A cloth over rigid bodies, each with a margin of its own.
static void StepDraped(World* world, uint32_t step)
{
    uint32_t side = 28;
    if (step == 0)
    {
        AddBody(world, qcMesh_MakeTorus(0.4, 0.1, 24, 8), false, qc_activityMoving);
        AddBody(world, qcMesh_MakeBox(0.2, 6, true), false, qc_activityStatic);
        AddBody(world, qcMesh_MakeBox(0.1, 4, false), false, qc_activityMoving);
        AddBody(world, qcMesh_MakeGrid(side, side, false, false), true, qc_activityMoving);
        CHECK_OK(qcScene_SetMargin(world->scene, world->ids[1], 0.002));
    }
    qcMesh* cloth = &world->meshes[3];
    for (uint32_t v = 0; v < cloth->vertexCount; v++)
    {
        double* x = cloth->positions + 3 * v;
        x[0] = 1.4 * (v % (side + 1)) / side - 0.7, x[1] = 1.4 * (v / (side + 1)) / side - 0.7;
        double r = x[0] * x[0] + x[1] * x[1] - 0.16;
        x[2] = 0.12 - 0.01 * step - r * r * (0.3 + 0.1 * step);
    }
    SetVertices(world, 3, step);
    Place(world, 2, 0.3, 0.45, 0.02 * step, 0.1);
}

#endif
