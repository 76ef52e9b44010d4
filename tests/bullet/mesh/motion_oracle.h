// An independent check that bodies don't meet within steps: exact tests at moments of the linear motion of vertices.
#ifndef QC_TESTS_BULLET_MESH_MOTION_ORACLE_H
#define QC_TESTS_BULLET_MESH_MOTION_ORACLE_H

#include "bullet/mesh/mesh_models.h"

#include "quickcullide/scene.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

struct qcWorldMesh
{
    std::vector<double> positions; ///< world space
    std::vector<uint32_t> indices;

    void Add(const btVector3& point)
    {
        positions.insert(positions.end(), {double(point.x()), double(point.y()), double(point.z())});
    }
};

/// The positions are rounded as doubles are: single ones differ by as much as surfaces may be apart.
inline qcWorldMesh qcWorldMeshOf(const qcModel& model, const btTransform& transform)
{
    qcWorldMesh soup;
    for (size_t i = 0; i < model.positions.size(); i += 3)
        for (int axis = 0; axis < 3; axis++)
        {
            double sum = double(transform.getOrigin()[axis]);
            for (int k = 0; k < 3; k++)
                sum += double(transform.getBasis()[axis][k]) * double(model.positions[i + size_t(k)]);
            soup.positions.push_back(sum);
        }
    soup.indices = model.indices;
    return soup;
}

/// A body of these triangles, which have to outlive the call that takes it.
inline qcBodyDef qcBodyOf(const qcWorldMesh& soup)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = soup.positions.data();
    def.positionType = qc_positionF64;
    def.vertexCount = uint32_t(soup.positions.size() / 3);
    def.indices = soup.indices.data();
    def.triangleCount = uint32_t(soup.indices.size() / 3);
    return def;
}

/// Triangles that are placed by their vertices. One scene serves all places: a scene's first query takes several times
/// as long as a later one.
class qcPlacedTriangles
{
  public:
    qcPlacedTriangles()
    {
        qcSceneDef def = qcDefaultSceneDef();
        ck_assert_int_eq(qcScene_Create(&def, &m_scene), qc_statusOk);
    }
    ~qcPlacedTriangles()
    {
        qcScene_Destroy(m_scene);
    }
    qcPlacedTriangles(const qcPlacedTriangles&) = delete;
    qcPlacedTriangles& operator=(const qcPlacedTriangles&) = delete;

    /// `owner`: see qcBodyDef.
    qcBodyId Add(const qcWorldMesh& soup, uint32_t owner = 0)
    {
        qcBodyDef def = qcBodyOf(soup);
        def.deforming = true;
        def.selfCollision = false;
        def.owner = owner;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(m_scene, &def, &id), qc_statusOk);
        return id;
    }
    void Remove(qcBodyId id)
    {
        ck_assert_int_eq(qcScene_RemoveBody(m_scene, id), qc_statusOk);
    }
    void Place(qcBodyId id, const std::vector<double>& positions)
    {
        ck_assert_int_eq(qcScene_SetVertices(m_scene, id, positions.data(), qc_positionF64, 0), qc_statusOk);
    }
    /// On the straight way from the start, at time 0, to the end, at 1.
    void PlaceBetween(qcBodyId id, const std::vector<double>& start, const std::vector<double>& end, double time)
    {
        std::vector<double> positions(end.size());
        for (size_t i = 0; i < end.size(); i++)
            positions[i] = (1 - time) * start[i] + time * end[i];
        Place(id, positions);
    }
    /// The pairs that penetrate, until the next call.
    const qcResult& Detect()
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.threads = 1;
        const qcResult* result = nullptr;
        ck_assert_int_eq(qcScene_Detect(m_scene, &def, &result), qc_statusOk);
        return *result;
    }

  private:
    qcScene* m_scene = nullptr;
};

/// Remembers where bodies were, and counts pairs of triangles of different bodies that penetrate on the way to where
/// they are.
class qcMotionOracle
{
  public:
    static constexpr int s_moments = 16;

    /// `now` returns the body's triangles where they are. `owner`: see qcBodyDef.
    void Add(std::function<qcWorldMesh()> now, uint32_t owner = 0)
    {
        Body body{std::move(now), {}, {}};
        qcWorldMesh soup = body.now();
        body.id = m_triangles.Add(soup, owner);
        body.start = std::move(soup.positions);
        m_bodies.push_back(std::move(body));
    }

    void Add(const qcModel& model, const btCollisionObject* object, uint32_t owner = 0)
    {
        Add([&model, object] { return qcWorldMeshOf(model, object->getWorldTransform()); }, owner);
    }

    /// The largest count at any moment since the last call; the last moment is the present, and a new start.
    size_t Count()
    {
        return CountOver(s_moments);
    }

    /// The count at present, which is a new start.
    size_t CountNow()
    {
        return CountOver(1);
    }

  private:
    struct Body
    {
        std::function<qcWorldMesh()> now;
        qcBodyId id;
        std::vector<double> start;
    };

    size_t CountOver(int moments)
    {
        std::vector<std::vector<double>> ends;
        for (const Body& body : m_bodies)
            ends.push_back(body.now().positions);
        size_t count = 0;
        for (int k = 1; k <= moments; k++)
        {
            for (size_t i = 0; i < m_bodies.size(); i++)
                if (m_bodies[i].start != ends[i])
                    m_triangles.PlaceBetween(m_bodies[i].id, m_bodies[i].start, ends[i], double(k) / moments);
            count = std::max(count, m_triangles.Detect().pairCount);
        }
        for (size_t i = 0; i < m_bodies.size(); i++)
            m_bodies[i].start = std::move(ends[i]);
        return count;
    }

    qcPlacedTriangles m_triangles;
    std::vector<Body> m_bodies;
};

#endif
