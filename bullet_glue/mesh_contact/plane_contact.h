// Contact of two meshes on both sides of a plane: what of them is next to the plane are two surfaces above it, and
// contact points are where a corner of one lies over the other, and where their edges cross.
#ifndef QC_GLUE_MESH_CONTACT_PLANE_CONTACT_H
#define QC_GLUE_MESH_CONTACT_PLANE_CONTACT_H

#include "mesh_contact/contact_reduction.h"
#include "mesh_contact/separating_axis.h"

/// Finds contact points up to a distance along the axis. Keeps its memory.
class qcPlaneContact
{
  public:
    /// Appends the contact points whose distance along the separation's axis is at most `distance`. Where no part of
    /// one mesh lies over the other: the closest points, if `orClosest`. False: there are none, or they are not known.
    /// O(vertices + triangles), and the square of what is next to the plane.
    bool Find(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation, btScalar distance,
              bool orClosest, std::vector<qcMeshPoint>* points);

    /// Appends the corners of a separation, common vertices of the two meshes, as contact points.
    static void AddTouching(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                            std::vector<qcMeshPoint>* points);

  private:
    /// A point in the plane's frame: two coordinates along it, and its height along the axis.
    struct Flat
    {
        btScalar u, v, height;
    };

    struct Edge
    {
        Flat from, to;
        uint32_t triangle;
    };

    struct Triangle
    {
        Flat corners[3];
        uint32_t index;
    };

    struct Vertex
    {
        Flat place;
        uint32_t triangle; ///< one of its triangles
    };

    /// A mesh's frame, seen along the axis.
    struct View
    {
        btVector3 u, v, height, offset;

        Flat operator()(const btVector3& point) const
        {
            return {u.dot(point) + offset.x(), v.dot(point) + offset.y(), height.dot(point) + offset.z()};
        }
    };

    /// What of a mesh is next to the plane.
    struct Side
    {
        std::vector<Vertex> vertices;
        std::vector<Triangle> triangles; ///< with a vertex next to the plane, but steep ones
        std::vector<Edge> edges;         ///< likewise; edges within flat faces are left out
        std::vector<uint32_t> near;      ///< vertices
        std::vector<uint8_t> isNear;     ///< by vertex
    };

    void Read(const qcPlacedSupport& placed, const btVector3& outward, btScalar thickness, Side* side) const;
    static void ReadTriangles(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side);
    static void ReadEdges(const qcSupportMesh& mesh, const View& view, uint32_t vertex, Side* side);
    void AddPoint(const Flat& onA, const Flat& onB, uint32_t triangleA, uint32_t triangleB);
    static bool FindHeight(const Triangle& triangle, const Flat& place, btScalar* height);
    void AddVertices(const Side& vertices, const Side& triangles, bool ofA);
    void AddCrossings();
    bool AddClosest(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation);

    btVector3 m_u, m_v, m_axis, m_origin;
    btScalar m_distance = 0;
    Side m_a, m_b;
    std::vector<qcMeshPoint> m_points;
    const qcMeshTriangles *m_trianglesA = nullptr, *m_trianglesB = nullptr;
};

#endif
