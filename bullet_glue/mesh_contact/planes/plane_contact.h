// Contact of two meshes on both sides of a plane: what of them is next to the plane are two surfaces above it, and
// contact points are where a corner of one lies over the other, and where their edges cross.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_PLANE_CONTACT_H
#define QC_GLUE_MESH_CONTACT_PLANES_PLANE_CONTACT_H

#include "mesh_contact/planes/flat_simplices.h"
#include "mesh_contact/planes/separating_axis.h"
#include "mesh_contact/points/contact_reduction.h"

/// Where hulls overlap by more than this part of the contact breaking threshold, no plane describes the contact of the
/// meshes.
constexpr btScalar qcMaxHullOverlap = btScalar(0.3);
/// Normals of faces are preferred to other axes that make the gap larger by up to this part of the threshold.
constexpr btScalar qcFaceSlack = btScalar(0.02);

/// Finds contact points up to a distance along the axis. Keeps its memory.
class qcPlaneContact
{
  public:
    /// Appends the contact points whose distance along the separation's axis is at most `distance`. Where no part of
    /// one mesh lies over the other: the closest points, if `orClosest`. False: there are none, or they are not known.
    /// O(vertices + triangles), and of what is next to the plane the pairs that overlap along one axis of the plane.
    /// Large meshes are read only where they overlap the other one.
    bool Find(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation, btScalar distance,
              bool orClosest, std::vector<qcMeshPoint>* points);

    /// Appends the corners of a separation, common vertices of the two meshes, as contact points.
    static void AddTouching(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                            std::vector<qcMeshPoint>* points);

  private:
    typedef qcFlatSimplices<2> Edges;
    typedef qcFlatSimplices<3> Triangles;

    struct Vertex
    {
        qcFlat place;
        uint32_t triangle; ///< one of its triangles
    };

    /// A mesh's frame, seen along the axis.
    struct View
    {
        btVector3 u, v, height, offset;

        qcFlat operator()(const btVector3& point) const
        {
            return {u.dot(point) + offset.x(), v.dot(point) + offset.y(), height.dot(point) + offset.z()};
        }
    };

    /// Box of a mesh within the plane.
    struct Extent
    {
        btScalar lower[2], upper[2]; ///< along u and v

        bool Overlaps(btScalar lowU, btScalar highU, btScalar lowV, btScalar highV) const
        {
            return lowU <= upper[0] && highU >= lower[0] && lowV <= upper[1] && highV >= lower[1];
        }
        template <size_t count> bool Overlaps(const qcFlat (&corners)[count]) const;
    };

    /// Vertices, edges and triangles of a mesh that are next to the plane, in the box of the other mesh.
    struct Side
    {
        Extent other;             ///< of the other mesh
        std::vector<size_t> runs; ///< of vertices whose triangles may be there
        std::vector<Vertex> vertices;
        Triangles triangles;         ///< with a vertex next to the plane, but steep ones
        Edges edges;                 ///< likewise; edges within flat faces are left out
        std::vector<uint32_t> near;  ///< vertices
        std::vector<uint8_t> isNear; ///< by vertex
    };

    /// Where an edge crosses another one.
    struct Crossing
    {
        uint32_t number; ///< of the other edge
        btScalar partA;  ///< of the edge of A
        btScalar heightB;
    };

    Extent ExtentOf(const qcPlacedSupport& placed) const;
    static void FindRuns(const qcSupportMesh& mesh, const View& view, Side* side);
    void Read(const qcPlacedSupport& placed, const qcPlacedSupport& other, const btVector3& outward, btScalar thickness,
              Side* side) const;
    static void ReadTriangles(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side);
    static void ReadEdges(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side);
    void AddPoint(const qcFlat& onA, const qcFlat& onB, uint32_t triangleA, uint32_t triangleB);
    void AddVertices(const Side& vertices, const Triangles& triangles, bool ofA);
    void AddCrossings(const qcFlat& from, const qcFlat& to, uint32_t triangle, const Edges& edges);
    bool AddClosest(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation);

    btVector3 m_u, m_v, m_axis, m_origin;
    btScalar m_distance = 0;
    btScalar m_slack = 0; ///< rounding of places along the plane
    Side m_a, m_b;
    std::vector<Crossing> m_crossings;
    std::vector<qcMeshPoint> m_points;
    const qcMeshTriangles *m_trianglesA = nullptr, *m_trianglesB = nullptr;
};

#endif
