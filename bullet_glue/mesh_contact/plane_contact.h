// Contact of two meshes on both sides of a plane: what of them is next to the plane are two surfaces above it, and
// contact points are where a corner of one lies over the other, and where their edges cross.
#ifndef QC_GLUE_MESH_CONTACT_PLANE_CONTACT_H
#define QC_GLUE_MESH_CONTACT_PLANE_CONTACT_H

#include "mesh_contact/contact_reduction.h"
#include "mesh_contact/separating_axis.h"

#include <algorithm>
#include <initializer_list>

/// Where hulls overlap by more than this part of the contact breaking threshold, no plane describes the contact of the
/// meshes.
constexpr btScalar qcMaxHullOverlap = btScalar(0.3);
/// Normals of faces are preferred to other axes that make the gap larger by up to this part of the threshold.
constexpr btScalar qcFaceSlack = btScalar(0.02);

/// A point in the frame of a plane: two coordinates along it, and its height.
struct qcFlat
{
    btScalar u, v, height;
};

/// A box around points, as seen along the plane's normal.
struct qcFlatBox
{
    btScalar lowU = BT_LARGE_FLOAT, highU = -BT_LARGE_FLOAT, lowV = BT_LARGE_FLOAT, highV = -BT_LARGE_FLOAT;
    uint32_t number = 0; ///< in the order of Add

    qcFlatBox(std::initializer_list<qcFlat> points)
    {
        for (const qcFlat& point : points)
        {
            lowU = std::min(lowU, point.u);
            highU = std::max(highU, point.u);
            lowV = std::min(lowV, point.v);
            highV = std::max(highV, point.v);
        }
    }
};

/// Boxes, sorted along one axis. Keeps its memory.
class qcFlatBoxes
{
  public:
    void Clear();
    void Add(std::initializer_list<qcFlat> corners);
    /// Call it after the last Add.
    void Sort();
    /// The numbers of the boxes that are at most `slack` from a box, the least first. Valid until the next call.
    /// O(boxes of which the widest one could reach the box).
    const std::vector<uint32_t>& FindNear(const qcFlatBox& box, btScalar slack);

  private:
    std::vector<qcFlatBox> m_boxes;
    std::vector<uint32_t> m_found;
    btScalar m_widest = 0;
};

/// Finds contact points up to a distance along the axis. Keeps its memory.
class qcPlaneContact
{
  public:
    /// Appends the contact points whose distance along the separation's axis is at most `distance`. Where no part of
    /// one mesh lies over the other: the closest points, if `orClosest`. False: there are none, or they are not known.
    /// O(vertices + triangles), and of what is next to the plane the pairs that overlap along one axis of the plane.
    bool Find(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation, btScalar distance,
              bool orClosest, std::vector<qcMeshPoint>* points);

    /// Appends the corners of a separation, common vertices of the two meshes, as contact points.
    static void AddTouching(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation,
                            std::vector<qcMeshPoint>* points);

  private:
    struct Edge
    {
        qcFlat from, to;
        uint32_t triangle;
    };

    struct Triangle
    {
        qcFlat corners[3];
        uint32_t index;
    };

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
    void AddPoint(const qcFlat& onA, const qcFlat& onB, uint32_t triangleA, uint32_t triangleB);
    static bool FindHeight(const Triangle& triangle, const qcFlat& place, btScalar* height);
    void AddVertices(const Side& vertices, const Side& triangles, bool ofA);
    void AddCrossing(const Edge& p, const Edge& q);
    void AddCrossings();
    bool AddClosest(const qcPlacedSupport& a, const qcPlacedSupport& b, const qcSeparation& separation);

    btVector3 m_u, m_v, m_axis, m_origin;
    btScalar m_distance = 0;
    btScalar m_slack = 0; ///< rounding of places along the plane
    Side m_a, m_b;
    qcFlatBoxes m_boxes;
    std::vector<qcMeshPoint> m_points;
    const qcMeshTriangles *m_trianglesA = nullptr, *m_trianglesB = nullptr;
};

#endif
