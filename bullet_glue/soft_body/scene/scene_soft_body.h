// A soft body of the scene: its state over a step, and what it collides with.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SCENE_SOFT_BODY_H
#define QC_GLUE_SOFT_BODY_SCENE_SCENE_SOFT_BODY_H

#include "common/object_key.h"
#include "soft_body/scene/topology.h"

#include "quickcullide/bullet_soft_body.h"

#include <algorithm>
#include <vector>

/// True if the body collides with the surfaces of Bullet's own shapes, and not by Bullet's tests of nodes or clusters.
bool qcCollidesWithSurfaces(const btSoftBody* body, const qcSoftBodySettings& settings);

/// The rigid side of a contact of the previous step.
struct qcHeldPoint
{
    qcObjectKey object{nullptr, -1};
    /// Where it was at the end of that step, less what a conveyor belt moves it by in the next.
    btVector3 point{0, 0, 0};
    btVector3 localPoint{0, 0, 0}, localNormal{0, 0, 0};

    btVector3 Point() const
    {
        return object.object->getWorldTransform() * localPoint;
    }
    btVector3 Normal() const
    {
        return object.object->getWorldTransform().getBasis() * localNormal;
    }
};

/// A contact of a soft body with a rigid object that it can't move, at the end of a step.
struct qcHeldContact
{
    qcHeldPoint rigid;
    int count = 0; ///< of nodes
    uint32_t nodes[3] = {0, 0, 0};
    btScalar weights[3] = {0, 0, 0}; ///< their sum is 1
    btScalar thickness = 0, friction = 0;
};

struct qcSceneRigid;

/// A node that is fixed to a point of a rigid object.
struct qcSoftAnchor
{
    uint32_t node;
    const btCollisionObject* object;
    btVector3 local;                ///< the point, in the object's frame
    qcSceneRigid* tiedTo = nullptr; ///< the object, if contacts move it with the node
    /// If the object can move: the nodes of the triangles with this node. The anchor holds them at the object. Contacts
    /// that push them off its surface in each step turn it like a motor.
    std::vector<uint32_t> neighbours;

    bool IsOneOf(const uint32_t nodes[3]) const
    {
        return node == nodes[0] || node == nodes[1] || node == nodes[2];
    }
    /// True if one of the three nodes is the node or a neighbour.
    bool IsAtOneOf(const uint32_t nodes[3]) const
    {
        return IsOneOf(nodes) ||
               std::find_first_of(neighbours.begin(), neighbours.end(), nodes, nodes + 3) != neighbours.end();
    }
};

/// A soft body of the scene.
struct qcSceneSoftBody
{
    btSoftBody* body = nullptr;
    int uniqueId = 0; ///< see qcUniqueIdOf
    qcBodyId id{};
    qcSoftTopology topology; ///< of the body in the scene
    qcSoftBodySettings settings;
    btScalar thickness = 0;          ///< settings.thickness, or the default where that is 0
    bool isNew = true;               ///< not yet tested for tangles at its start
    bool moves = true;               ///< false: Bullet does not simulate it at present, and contacts don't move it
    bool startsWhereItEnded = false; ///< its state is that of the end of the previous step
    bool hasEnd = false;             ///< `positions` are those of the end of the previous step
    bool startsElsewhere = true;     ///< it is new, or was put elsewhere since
    bool isRestored = false;         ///< see FindRestored
    /// Node positions when the application last changed the topology, as by a cut; empty: it has not.
    std::vector<btVector3> cutPositions;
    /// Node positions at the start of the step: where the previous step left them, so that nodes that the application
    /// moves between two steps don't jump through anything. A body that it moves by more than half its size is put
    /// elsewhere, and starts there.
    std::vector<btVector3> start;
    /// How far the application has moved the nodes since the previous step; empty: none, or the body starts elsewhere.
    std::vector<btVector3> applied;
    std::vector<btVector3> velocities;            ///< of the nodes at the end of the previous step
    std::vector<btVector3> solved;                ///< after Bullet's own solvers
    btVector3 solvedBox[2]{{0, 0, 0}, {0, 0, 0}}; ///< around `start` and `solved`
    bool hasSolvedBox = false;                    ///< there are nodes, and the box is finite
    btVector3 collectedBox[2];                    ///< the scene has the meshes in it
    bool isSolvedStretched = false;               ///< qcIsStretchedChain from `start` to `solved`
    std::vector<btVector3> positions; ///< after contacts so far; copied to Bullet's nodes at the end of the step
    /// The parts of the positions that untangling, links that contract, or in the deformable world the restoring of
    /// gaps, added in this step; they give no velocity. Empty: none.
    std::vector<btVector3> shifts;
    int strainedSteps = 0;    ///< for which links bring back how far untangling has moved nodes
    std::vector<bool> pinned; ///< nodes that contacts don't move, but for those of TiedTo; empty: none
    /// Nodes that are anchored to a rigid object: their triangles don't collide with that, since an anchor may lie
    /// inside.
    std::vector<qcSoftAnchor> anchors;
    std::vector<qcHeldContact> heldContacts; ///< of the previous step
    bool inContact = false;                  ///< it is in a constraint of this step
    bool hasPartner = true;                  ///< its motion may come near that of another soft body or a mesh
    bool isApart = false;                    ///< it can't touch itself in this step: queries don't test it with itself
    /// Nothing comes near it in this step, itself included: queries leave it out.
    bool isAlone = false;
    bool isInScene = false; ///< the scene has its positions

    /// The body's own friction, and that against a rigid object: see qcSoftBodySettings.
    btScalar Friction() const;
    btScalar FrictionOn(const btCollisionObject& rigid) const;
    /// Reads how far the application has moved the nodes, in this member, since the end of the previous step. False:
    /// the body starts elsewhere, since a node is further from there than half the size that the body had.
    bool ReadApplied(btVector3 btSoftBody::Node::*member);
    /// True if the application has moved the node since the previous step.
    bool IsApplied(size_t node) const
    {
        return isRestored || (!applied.empty() && !applied[node].isZero());
    }
    /// The application has changed the topology: reads where the nodes, by this member, are now.
    void ReadCut(btVector3 btSoftBody::Node::*member);
    /// Finds out whether the application has restored another state since the end of the previous step, as a rollback
    /// does: more than half of the nodes that Bullet moves have another position and another velocity.
    void FindRestored();
    /// Reads which nodes are anchored, and which ones Bullet itself places at the end of each step. O(nodes +
    /// triangles + triangles at anchors * anchors).
    void ReadAnchors();
    /// Reads the positions after Bullet's own solvers, and finds the box of the motion from the start of the step.
    /// False: a node is not finite, and the body stays at its start for contact.
    bool ReadSolved();
    /// True if the body, a chain, runs along one direction over its motion. `starts`: its positions are those after
    /// Bullet's solvers.
    bool IsStretched(bool starts);

    int NodeCount() const
    {
        return body->m_nodes.size();
    }
    size_t IndexOf(const btSoftBody::Node* node) const
    {
        return size_t(node - &body->m_nodes[0]);
    }
    /// The motion of a node in the step, without the shift.
    btVector3 MotionOf(size_t node, const btVector3& from) const
    {
        return positions[node] - from - (shifts.empty() ? btVector3(0, 0, 0) : shifts[node]);
    }
    /// Moves the nodes without velocity.
    void Shift(const std::vector<btVector3>& by);
    /// Leaves the nodes' velocities, of what links add to their motion, the share at which this takes the most kinetic
    /// energy (factor 1), or the largest share at which it adds none (factor 2). without(node): the motion without it.
    template <typename Function>
    void LimitLinks(const std::vector<btVector3>& byLinks, double factor, const Function& without)
    {
        double work = 0, square = 0;
        for (size_t i = 0; i < byLinks.size(); i++)
        {
            const btScalar inverseMass = body->m_nodes[int(i)].m_im;
            if (!(inverseMass > 0))
                continue;
            work += double(byLinks[i].dot(without(i)) / inverseMass);
            square += double(byLinks[i].length2() / inverseMass);
        }
        const double share = square > 0 ? std::min(std::max(-factor * work / square, 0.0), 1.0) : 1;
        if (!(share < 1))
            return;
        shifts.resize(positions.size(), btVector3(0, 0, 0));
        for (size_t i = 0; i < byLinks.size(); i++)
            shifts[i] += byLinks[i] * btScalar(1 - share);
    }
    /// Where the step starts for a node's velocity: behind the application's motion.
    btVector3 VelocityStartOf(size_t node) const
    {
        return applied.empty() ? start[node] : start[node] + applied[node];
    }
    /// The motion that gives a node its velocity: without the shift, and without what contacts have taken back of the
    /// application's motion.
    btVector3 VelocityMotionOf(size_t node, const btVector3& from) const;
    /// Calls function(node index) for each node that contacts moved, or whose velocity a shift changes.
    template <typename Function> void ForEachMoved(Function function) const
    {
        for (size_t i = 0; i < positions.size(); i++)
            if (!qcAreSame(positions[i], solved[i]) || (!shifts.empty() && !shifts[i].isZero()))
                function(int(i));
    }
    /// True if contacts have moved no node so far.
    bool IsSolved() const
    {
        auto isSame = [](const btVector3& a, const btVector3& b) { return qcAreSame(a, b); };
        return std::equal(positions.begin(), positions.end(), solved.begin(), isSame);
    }
    /// The box of the motion to the present positions, enlarged by `reach`. False: a node is not finite, or there is
    /// none.
    bool FindMotionBox(btScalar reach, btVector3 box[2]) const;
    /// 0: contacts don't move the node.
    btScalar InverseMass(uint32_t node) const
    {
        bool isFixed = !moves || (!pinned.empty() && pinned[node]);
        return isFixed ? btScalar(0) : body->m_nodes[int(node)].m_im;
    }
    /// The body that the node moves with in contact, or null.
    qcSceneRigid* TiedTo(uint32_t node) const
    {
        if (pinned.empty() || !pinned[node])
            return nullptr;
        auto anchor = std::find_if(anchors.begin(), anchors.end(),
                                   [node](const qcSoftAnchor& other) { return other.node == node; });
        return anchor != anchors.end() ? anchor->tiedTo : nullptr;
    }
    bool CollidesWithRigidBodies() const
    {
        return (body->m_cfg.collisions & btSoftBody::fCollision::RVSmask) != 0;
    }
    /// True if one of the three nodes is anchored to the object or, if that can move, has a neighbour that is.
    bool IsAnchored(const uint32_t nodes[3], const btCollisionObject* object) const
    {
        return std::any_of(anchors.begin(), anchors.end(),
                           [&](const qcSoftAnchor& anchor)
                           { return anchor.object == object && anchor.IsAtOneOf(nodes); });
    }
    /// True if a triangle of this body and one of another body, or of this one, are anchored at one point of an object:
    /// they meet there, whatever contacts do.
    bool IsTiedTo(const qcSceneSoftBody& other, const uint32_t nodes[3], const uint32_t nodesOfOther[3]) const;
    bool CollidesWithSurfaces() const
    {
        return qcCollidesWithSurfaces(body, settings);
    }
};

#endif
