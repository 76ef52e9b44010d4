// The triangles of a world's objects.
#ifndef QC_DEMOS_VIEW_GEOMETRY_H
#define QC_DEMOS_VIEW_GEOMETRY_H

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

class btSoftBody;

struct qcShadedVertex
{
    float position[3], normal[3];
};

/// Triangles in a frame of their own; of soft bodies in world space.
struct qcViewTriangles
{
    uint64_t id = 0;      ///< different for any two
    uint64_t changes = 0; ///< counts changes of positions
    std::vector<float> positions;
    std::vector<uint32_t> indices;
    std::vector<qcShadedVertex> shaded; ///< three for each triangle
};

/// One shape of an object.
struct qcViewSurface
{
    const btCollisionObject* object = nullptr;
    uint32_t number = 0; ///< of the object, by its first appearance
    std::shared_ptr<qcViewTriangles> triangles;
    btTransform place = btTransform::getIdentity();
    bool deforming = false;
    bool unbounded = false; ///< a part of a plane
};

class qcViewGeometry
{
  public:
    /// Reads the world's present shapes and positions. Triangles of shapes that stay are kept.
    void Update(const btCollisionWorld& world);
    /// Forgets everything: another world follows.
    void Clear();

    const std::vector<qcViewSurface>& Surfaces() const
    {
        return m_surfaces;
    }
    /// The box around all bounded surfaces.
    const btVector3& Lower() const
    {
        return m_lower;
    }
    const btVector3& Upper() const
    {
        return m_upper;
    }

  private:
    /// A shape as it was when its triangles were made. Addresses are used again by other shapes.
    struct Known
    {
        const void* shape;
        int type;
        uint64_t revision;
        btVector3 scaling;

        bool operator<(const Known& other) const;
    };

    void AddShape(const btCollisionObject* object, uint32_t number, const btCollisionShape* shape,
                  const btTransform& place);
    void AddSoftBody(const btSoftBody* body, uint32_t number);
    std::shared_ptr<qcViewTriangles> Find(const Known& known, bool* isNew);
    void AddBounds(const btCollisionObject* object);

    std::map<Known, std::shared_ptr<qcViewTriangles>> m_known, m_used;
    std::map<std::pair<const btCollisionObject*, int>, uint32_t> m_numbers; ///< by object and proxy
    std::vector<qcViewSurface> m_surfaces;
    btVector3 m_lower{0, 0, 0}, m_upper{0, 0, 0};
    uint32_t m_nextNumber = 0;
    uint64_t m_nextId = 0;
};

#endif
