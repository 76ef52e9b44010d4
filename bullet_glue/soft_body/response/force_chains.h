// Chains of contacts through which a rigid body presses on another one, with soft nodes in between.
//
// Sweeps over contacts converge the more slowly, the heavier a rigid body is than the nodes that it presses on: a push
// moves the nodes, and only the next sweep brings them on what is behind them. The sum of the constraints along a chain
// is implied by them. In it the nodes cancel out where all normals are parallel: it acts on the rigid bodies.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_FORCE_CHAINS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_FORCE_CHAINS_H

#include "soft_body/response/position_constraints.h"

#include <unordered_map>
#include <utility>

class qcForceChains
{
  public:
    /// Finds the chains among constraints, to which the other functions refer by their places, and marks their members.
    /// O(n log n).
    void Find(std::vector<qcSoftConstraint>* constraints);
    void Clear();
    /// Forgets the forces so far. Call it before sweeps.
    void Begin();
    /// Iterations over all chains. False: they were satisfied, and nothing has moved.
    bool Solve(std::vector<qcSoftConstraint>* constraints);

  private:
    /// A constraint of the chain, and its share of the chain's force.
    struct Member
    {
        size_t constraint;
        btScalar share;
        btScalar sign; ///< -1: its offset runs against the chain's
        size_t body;   ///< of its rigid object: index in m_activeCounts
    };
    /// The sum of the members' forces on a node, for a unit of the chain's force.
    struct NodeForce
    {
        const btVector3* node;
        btScalar inverseMass;
        btVector3 force;
    };
    struct Chain
    {
        size_t firstMember, memberEnd;
        btVector3 normal; ///< from the first object to the others
        btScalar friction;
        btScalar nodeYield = 0;     ///< how far a unit of force moves nodes on which it does not cancel out
        btVector3 sliding{0, 0, 0}; ///< of the first contact's nodes over the first object since the start of the step
        btScalar missing = 0;       ///< of the sum of the members' distances
        btScalar pushed = 0;        ///< impulse along the normal so far, times the time step
        btVector3 rubbed{0, 0, 0};  ///< likewise, of friction, on the first object
        btScalar push = 0;          ///< the part of `pushed` that is new
        btVector3 rub{0, 0, 0};
        bool isActive = false;
    };
    /// A constraint in which a node is a side of its own.
    struct Support
    {
        const btVector3* node;
        size_t constraint;
        btScalar weight; ///< of the node: 1 or -1
    };

    void FindSupports(const std::vector<qcSoftConstraint>& constraints);
    const Support* SupportOf(const std::vector<qcSoftConstraint>& constraints, const btVector3* node,
                             const btVector3& normal) const;
    size_t BodyOf(const void* body);
    void AddLoads(const qcSoftConstraint& constraint, btScalar share, btScalar side);
    void AddMember(const qcSoftConstraint& constraint, const Member& member);
    void AddForces(const qcSoftConstraint& constraint, btScalar share);
    bool Follow(const std::vector<qcSoftConstraint>& constraints, size_t first);
    void AddChain(const std::vector<qcSoftConstraint>& constraints, size_t first);
    void Measure(const std::vector<qcSoftConstraint>& constraints, Chain* chain) const;
    bool MeasureAll(const std::vector<qcSoftConstraint>& constraints);
    btScalar YieldAlong(const std::vector<qcSoftConstraint>& constraints, const Chain& chain,
                        const btVector3& direction) const;
    void Respond(std::vector<qcSoftConstraint>* constraints, Chain* chain) const;
    void Push(const std::vector<qcSoftConstraint>& constraints, const Chain& chain) const;

    std::vector<Chain> m_chains;
    std::vector<Member> m_members;
    std::vector<NodeForce> m_forces;                            ///< of the chain that is being followed
    std::vector<Support> m_supports;                            ///< in the order of their nodes
    std::unordered_map<const void*, size_t> m_bodies;           ///< rigid objects
    std::vector<int> m_activeCounts;                            ///< by body: its active chains
    std::vector<std::pair<const btVector3*, btScalar>> m_loads; ///< nodes to be supported, with their shares
};

#endif
