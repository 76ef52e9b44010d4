// An orbiting camera.
#include "view/camera.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr btScalar s_halfHeight = btScalar(0.287); // tangent of half the field of view: 32 degrees
constexpr btScalar s_maxPitch = btScalar(1.54);
} // namespace

qcMatrix qcMultiply(const qcMatrix& a, const qcMatrix& b)
{
    qcMatrix product{};
    for (size_t column = 0; column < 4; column++)
        for (size_t row = 0; row < 4; row++)
            for (size_t k = 0; k < 4; k++)
                product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    return product;
}

qcMatrix qcLookAt(const btVector3& eye, const btVector3& target, const btVector3& up)
{
    btVector3 back = (eye - target).normalized(), right = up.cross(back).normalized(), upward = back.cross(right);
    qcMatrix m{};
    const btVector3 rows[3] = {right, upward, back};
    for (size_t row = 0; row < 3; row++)
    {
        for (size_t column = 0; column < 3; column++)
            m[4 * column + row] = float(rows[row][int(column)]);
        m[12 + row] = -float(rows[row].dot(eye));
    }
    m[15] = 1;
    return m;
}

qcMatrix qcOrthographic(float halfWidth, float halfHeight, float near, float far)
{
    qcMatrix m{};
    m[0] = 1 / halfWidth;
    m[5] = 1 / halfHeight;
    m[10] = -2 / (far - near);
    m[14] = -(far + near) / (far - near);
    m[15] = 1;
    return m;
}

void qcViewCamera::Place(const btVector3& eye, const btVector3& target)
{
    btVector3 arm = eye - target;
    m_target = target;
    m_distance = arm.length();
    m_yaw = std::atan2(arm.x(), arm.z());
    m_pitch = std::asin(std::min(std::max(arm.y() / m_distance, btScalar(-1)), btScalar(1)));
}

void qcViewCamera::Orbit(btScalar right, btScalar up)
{
    m_yaw -= right;
    m_pitch = std::min(std::max(m_pitch + up, -s_maxPitch), s_maxPitch);
}

void qcViewCamera::Pan(btScalar right, btScalar up)
{
    btVector3 axes[3];
    Axes(axes);
    m_target -= (axes[0] * right + axes[1] * up) * (2 * s_halfHeight * m_distance);
}

void qcViewCamera::Zoom(btScalar factor)
{
    m_distance *= factor;
}

void qcViewCamera::LookAt(const btVector3& target)
{
    m_target = target;
}

void qcViewCamera::Axes(btVector3 axes[3]) const
{
    axes[2] = btVector3(std::sin(m_yaw) * std::cos(m_pitch), std::sin(m_pitch), std::cos(m_yaw) * std::cos(m_pitch));
    axes[0] = btVector3(std::cos(m_yaw), 0, -std::sin(m_yaw));
    axes[1] = axes[2].cross(axes[0]);
}

btVector3 qcViewCamera::Eye() const
{
    btVector3 axes[3];
    Axes(axes);
    return m_target + axes[2] * m_distance;
}

qcMatrix qcViewCamera::ViewProjection(btScalar aspect, btScalar extent) const
{
    float far = float(m_distance + 30 * extent), near = float(m_distance) * 0.02f;
    qcMatrix projection{};
    projection[0] = 1 / float(s_halfHeight * aspect);
    projection[5] = 1 / float(s_halfHeight);
    projection[10] = -(far + near) / (far - near);
    projection[11] = -1;
    projection[14] = -2 * far * near / (far - near);
    return qcMultiply(projection, qcLookAt(Eye(), m_target, btVector3(0, 1, 0)));
}

btVector3 qcViewCamera::Ray(btScalar x, btScalar y, btScalar aspect) const
{
    btVector3 axes[3];
    Axes(axes);
    return (axes[0] * (x * s_halfHeight * aspect) + axes[1] * (y * s_halfHeight) - axes[2]).normalized();
}
