// The time of a step of Bullet by stage: Bullet's own stages, and those of this library.
#ifndef QC_DEMOS_COMMON_BULLET_STEP_COSTS_H
#define QC_DEMOS_COMMON_BULLET_STEP_COSTS_H

#include "quickcullide/bullet_mesh.h"
#include "quickcullide/bullet_soft_body.h"

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

/// In the order of a step.
enum qcStepCost
{
    qc_costBoxes,     ///< Bullet: boxes of all objects, handed to the broadphase
    qc_costPairs,     ///< the broadphase finds pairs of boxes
    qc_costGather,    ///< ours: geometry is read from Bullet
    qc_costAhead,     ///< ours: speculative contacts of fast bodies
    qc_costCull,      ///< ours: the stages of the query
    qc_costSweep,     ///< ours
    qc_costExact,     ///< ours
    qc_costPoints,    ///< ours: contact points
    qc_costOther,     ///< ours: the rest of the query
    qc_costManifolds, ///< collision algorithms fill manifolds: ours from these points, and Bullet's own
    qc_costRespond,   ///< ours: soft bodies move apart
    qc_costRigid,     ///< Bullet: islands and constraints of rigid bodies
    qc_costSoft,      ///< Bullet: constraints of soft bodies
    qc_costBreak,     ///< a body is broken, and replaced by its pieces
    qc_costRest,      ///< Bullet: forces, motion, sleeping
    qc_costCount
};

/// Milliseconds; no time is part of two costs.
struct qcStepCosts
{
    std::array<double, qc_costCount> ms{};

    double Total() const;
    /// Moves a part of the cost `from` to the cost `to`.
    void Move(qcStepCost from, qcStepCost to, double part);
    /// Moves the parts of a query for contact of meshes out of qc_costManifolds.
    void MoveQuery(const qcMeshContactStatistics& query);
    /// Moves the parts of soft bodies' contact out of qc_costRest.
    void MoveSoft(const qcSoftBodyStatistics& statistics);
    void Add(const qcStepCosts& other, double weight);
};

/// Means of the costs of steps; `begin` and `end` are iterators over structs with a member `costs`.
template <typename Iterator> qcStepCosts qcMeanCosts(Iterator begin, Iterator end)
{
    qcStepCosts mean;
    for (Iterator step = begin; step != end; ++step)
        mean.Add(step->costs, 1 / double(end - begin));
    return mean;
}

/// Makes one step of `seconds` and times it by Bullet's own profile zones. Costs marked `ours` stay 0: their time is
/// included in the cost of the enclosing zone; see Move. If Bullet was built without zones, all time is in qc_costRest.
/// One thread at a time.
qcStepCosts qcTimeStep(btDynamicsWorld* world, double seconds);

/// The label of a cost in tables.
const char* qcStepCostLabel(qcStepCost cost);

/// Prints a table to standard output, a column for each step or mean of steps. Rows of zeros are left out.
void qcPrintStepCosts(const char* heading, const std::vector<std::pair<std::string, qcStepCosts>>& columns);

#endif
