// The scene in which the motions of a step are certified.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_SCENE_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_SCENE_H

#include "mesh_contact/limits/swept_triangles.h"

#include <set>

/// Holds the meshes of the objects that have been near others; of a large compound at rest, those that others have been
/// near. Not for several threads.
class qcSweptScene
{
  public:
    explicit qcSweptScene(const qcBatchSettings& settings) : m_settings(settings)
    {
    }
    ~qcSweptScene();
    qcSweptScene(const qcSweptScene&) = delete;
    qcSweptScene& operator=(const qcSweptScene&) = delete;

    /// Finds the pairs of triangles that are not proven apart, of these pairs of objects, by number (qcIsBefore). Those
    /// in `inner` are tested by inner cores in place of cores. The result is valid until the next call.
    qcStatus Detect(const std::vector<qcSweptPair>& pairs, const std::set<qcPairNumbers>& inner,
                    const qcResult** result);
    /// The objects of a pair of triangles.
    qcPairNumbers NumbersOf(const qcPair& pair) const;
    qcSweptTriangles TrianglesOf(const qcPair& pair, const qcProximity& atStart) const;

    /// Null before the first detection.
    qcScene* Get()
    {
        return m_scene;
    }

  private:
    struct Side
    {
        qcSweptObject* swept;
        const qcSweptMesh* mesh;
    };

    void CollectObjects();
    void FindNearChildren() const;
    qcStatus AddMesh(qcSweptObject* swept, size_t index);
    qcStatus AddMeshes(qcSweptObject* swept);
    qcStatus PlaceMeshes(bool atStart) const;
    Side SideOf(uint32_t slot) const;
    static bool TestPair(void* context, uint32_t slotA, uint32_t slotB);

    const qcBatchSettings& m_settings;
    qcScene* m_scene = nullptr;
    const std::vector<qcSweptPair>* m_pairs = nullptr;           ///< of the present detection
    std::vector<qcSweptObject*> m_objects;                       ///< of these pairs
    uint64_t m_detection = 0;                                    ///< number of the present one
    const std::set<qcPairNumbers>* m_inner = nullptr;            ///< likewise
    std::vector<std::pair<qcSweptObject*, size_t>> m_meshOfSlot; ///< object and index of its mesh
};

#endif
