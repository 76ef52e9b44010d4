// Zones: parts of soft bodies and meshes that planes can't keep apart move through a step as one rigid body.
//
// What was apart at the start of the step stays apart inside of a zone. Its motion is the mean of what its parts were
// about to do: linear momentum is kept. A zone that holds something pinned moves as that does.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_RIGID_ZONES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_RIGID_ZONES_H

#include "common/union_find.h"
#include "soft_body/scene/soft_scene.h"

class qcSoftZones
{
  public:
    explicit qcSoftZones(qcSoftBodyScene& scene) : m_scene(scene)
    {
    }

    void Clear();
    /// Unites both triangles of a pair, and the zones that they are in. False if they are in one zone already, and that
    /// is where it started: nothing is left to do.
    bool Add(const qcPair& pair);
    /// Moves all zones from the start of the step.
    void Move();
    /// Of all zones.
    int NodeCount() const;

  private:
    /// A node, or an object with meshes.
    struct Part
    {
        qcSceneSoftBody* soft;
        qcSceneRigid* rigid; ///< null for a node
        uint32_t node;
        btTransform target; ///< before zones moved it; of a node its position, without what untangling moved it by
    };

    void Begin();
    void AddPartsOf(uint32_t slot, uint32_t triangle, std::vector<uint32_t>* parts) const;
    btTransform MotionOf(const std::vector<uint32_t>& zone) const;
    void MoveZone(const std::vector<uint32_t>& zone);

    qcSoftBodyScene& m_scene;
    std::vector<Part> m_parts;         ///< all nodes, body by body, then all objects; empty before the first Add
    qcUnionFind m_sets;                ///< of parts: the zones
    std::vector<bool> m_isMember;      ///< of a zone
    std::vector<uint32_t> m_zones;     ///< roots at the last Move
    std::vector<bool> m_isHeld;        ///< of a root: the zone goes back to where it started, exactly
    std::vector<uint32_t> m_firstNode; ///< of each soft body
    uint32_t m_firstObject = 0;        ///< number of its part
};

#endif
