// Debug lines and triangles.
#include "view/overlay.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace
{
constexpr btScalar s_inPlane = btScalar(1e-4); // world units

void Add(const btVector3& position, const btVector3& color, std::vector<qcColoredVertex>* vertices)
{
    vertices->push_back({{float(position.x()), float(position.y()), float(position.z())},
                         {float(color.x()), float(color.y()), float(color.z())}});
}
} // namespace

void qcViewOverlay::Begin(btScalar size)
{
    m_size = size;
    m_leftOut.clear();
    m_lines.clear();
    m_triangles.clear();
}

void qcViewOverlay::LeaveOut(const btVector3& point, const btVector3& normal)
{
    m_leftOut.push_back({point, normal});
}

void qcViewOverlay::drawLine(const btVector3& from, const btVector3& to, const btVector3& color)
{
    Add(from, color, &m_lines);
    Add(to, color, &m_lines);
}

void qcViewOverlay::drawTriangle(const btVector3& a, const btVector3& b, const btVector3& c, const btVector3& color,
                                 btScalar)
{
    const std::array<btVector3, 3> corners = {a, b, c};
    for (const Plane& plane : m_leftOut)
        if (std::all_of(corners.begin(), corners.end(),
                        [&](const btVector3& corner)
                        { return std::abs((corner - plane.point).dot(plane.normal)) < s_inPlane; }))
            return;
    for (const btVector3& corner : corners)
        Add(corner, color, &m_triangles);
}

/// A cross in the plane of contact, and the normal.
void qcViewOverlay::drawContactPoint(const btVector3& point, const btVector3& normal, btScalar, int, const btVector3&)
{
    const btVector3 dark(btScalar(0.05), btScalar(0.05), btScalar(0.1));
    btVector3 u, v;
    btPlaneSpace1(normal, u, v);
    drawLine(point - u * (m_size / 3), point + u * (m_size / 3), dark);
    drawLine(point - v * (m_size / 3), point + v * (m_size / 3), dark);
    drawLine(point, point + normal * m_size, dark);
}

btIDebugDraw::DefaultColors qcViewOverlay::getDefaultColors() const
{
    DefaultColors colors;
    colors.m_aabb = btVector3(btScalar(0.55), btScalar(0.35), btScalar(0.85));
    colors.m_contactPoint = btVector3(btScalar(0.55), btScalar(0.35), btScalar(0.85));
    return colors;
}
