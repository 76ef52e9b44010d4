// A scene that changes in each step, and a model of what is in it: a new scene made from the model alone gives the same
// results, to the last bit. Bodies are few and small, so that a million steps take a minute.
#ifndef QC_TESTS_LONG_CHANGING_WORLD_H
#define QC_TESTS_LONG_CHANGING_WORLD_H

#include "support/scenes.h"

enum
{
    qc_worldBodies = 12,
    qc_worldBodiesEver = 64 ///< ids of removed bodies that are remembered
};

typedef struct qcWorldBody
{
    bool isUsed;
    qcBodyId id;
    qcBodyDef def;              ///< as last set; positions and transform are the present ones
    qcSoup soup;                ///< the present positions
    bool isMarked;              ///< the body was there at the last mark
    double* startPositions;     ///< at the last mark, of deforming bodies
    qcTransform startTransform; ///< at the last mark
} qcWorldBody;

typedef struct qcWorld
{
    qcRandom random;
    qcScene* scene;
    qcWorldBody bodies[qc_worldBodies];
    qcBodyId removed[qc_worldBodiesEver]; ///< the last ones
    uint64_t removedCount;
    uint64_t changes; ///< calls that changed the scene
} qcWorld;

void qcWorld_Create(qcWorld* world, uint64_t seed, qcDevice* device);
void qcWorld_Destroy(qcWorld* world);
/// Adds, removes, moves or bends bodies, changes settings, or marks the start: one to three changes.
void qcWorld_Change(qcWorld* world);
/// Removes all bodies.
void qcWorld_Clear(qcWorld* world);
/// A random request of one thread: method, margins, contacts, manifolds, motion.
qcDetectDef qcWorld_MakeDef(qcWorld* world);
/// A new scene with the same bodies in the same slots, and the same start. Destroy it with qcScene_Destroy.
qcScene* qcWorld_Rebuild(const qcWorld* world);
/// Detects in the living scene and in a new one: both results have the same hash. The number of pairs and contacts.
size_t qcWorld_Compare(qcWorld* world, const qcDetectDef* def, const char* where);
/// The ids of removed bodies name nothing.
void qcWorld_CheckRemoved(const qcWorld* world);

#endif
