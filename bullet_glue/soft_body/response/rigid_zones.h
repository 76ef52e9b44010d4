// Zones: nodes and meshes that separating planes could not keep apart, which move through the step as one rigid body.
//
// A zone's motion has the linear and angular momentum of its members' own motions; a fixed member determines it alone,
// and where a mesh deforms, the mean motion of its triangles in the zone. A pair in a zone that is still not proven
// apart takes the zone's rotation, then all its motion. Proof: plugin/docs/proofs/rigid_zones.md.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_RIGID_ZONES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_RIGID_ZONES_H

#include "common/union_find.h"
#include "soft_body/scene/soft_scene.h"

class qcRigidZones
{
  public:
    explicit qcRigidZones(qcSoftBodyScene& scene) : m_scene(scene)
    {
    }

    void Clear();
    /// Unites the zones of both triangles of a pair that is not proven apart. False: nothing has changed, since both
    /// are in one zone that has been returned to its start already.
    bool Add(const qcPair& pair);
    /// Objects have been fixed where they are now: zones follow them, and have all their motions again.
    void Renew();
    /// Moves all zones from the start of the step.
    void Move();
    /// True if both triangles have made the motion of one zone, up to rounding that is too small to close their
    /// distance at the start: they are apart at every time, whatever the rotation.
    bool KeepsApart(const qcPair& pair, btScalar distance) const;
    /// Nodes in zones.
    int NodeCount() const;
    /// Calls function(object) for each object in the zone of a pair.
    template <typename Function> void ForEachObjectWith(const qcPair& pair, Function function) const
    {
        const uint32_t zone = ZoneOf(pair);
        for (size_t i = m_firstObject; zone != s_none && i < m_members.size(); i++)
            if (m_isInZone[i] && m_zones[i] == zone)
                function(*m_members[i].rigid);
    }
    /// Calls function(body, node) for each node in a zone.
    template <typename Function> void ForEachNode(Function function) const
    {
        for (size_t i = 0; i < m_members.size(); i++)
            if (m_isInZone[i] && m_members[i].rigid == nullptr)
                function(*m_members[i].soft, m_members[i].node);
    }

  private:
    /// How a zone moves, from the first that is tried to the last.
    enum class Motion : uint8_t
    {
        Rigid,
        Translation,
        None ///< the zone returns to its start, exactly
    };

    struct State
    {
        Motion min = Motion::Rigid; ///< the first motion that is left to it
        bool hasGrown = false;      ///< since the last Move
    };

    /// A node, or an object with meshes.
    struct Member
    {
        qcSceneSoftBody* soft;
        qcSceneRigid* rigid; ///< null for a node
        uint32_t node;
        btTransform
            target; ///< of an object: transform at the end of its own motion; of a node: position without its shift
    };

    /// A triangle of a mesh that deforms, in an unproven pair.
    struct Carrier
    {
        uint32_t member;  ///< of the zone that goes with it
        btVector3 motion; ///< mean of its corners
    };

    /// The carriers of a zone.
    struct Carried
    {
        btVector3 sum{0, 0, 0}; ///< of their motions
        int count = 0;
    };

    static constexpr uint32_t s_none = UINT32_MAX;

    void CollectMembers();
    void CollectObjects();
    uint32_t ZoneOf(const qcPair& pair) const;
    void Carry(uint32_t slot, uint32_t triangle, uint32_t member);
    void AppendMembersOf(uint32_t slot, uint32_t triangle, std::vector<uint32_t>* members) const;
    void AppendTied(std::vector<uint32_t>* members) const;
    uint32_t MemberOf(const qcSceneRigid* rigid) const;
    uint32_t MemberOf(const qcSceneSoftBody* soft, uint32_t node) const
    {
        return m_firstNode[size_t(soft - m_scene.Bodies().data())] + node;
    }
    static btScalar InverseMassOf(const Member& node);
    btTransform FindMotion(const std::vector<uint32_t>& zone, bool rotates) const;
    void MoveZone(const std::vector<uint32_t>& zone);
    btScalar DeviationOf(uint32_t slot, uint32_t triangle, const btTransform& motion) const;

    qcSoftBodyScene& m_scene;
    std::vector<Member> m_members;      ///< all nodes by body, then all objects; empty before the first Add
    qcUnionFind m_sets;                 ///< of members: the zones
    std::vector<bool> m_isInZone;       ///< by member
    std::vector<uint32_t> m_zones;      ///< by member: its zone in the last Move
    std::vector<State> m_states;        ///< by representative
    std::vector<Motion> m_moved;        ///< by representative in the last Move
    std::vector<btTransform> m_motions; ///< likewise
    std::vector<Carrier> m_carriers;
    std::vector<Carried> m_carried;    ///< by representative in the last Move
    std::vector<uint32_t> m_firstNode; ///< member index, by soft body
    uint32_t m_firstObject = 0;        ///< member index
};

#endif
