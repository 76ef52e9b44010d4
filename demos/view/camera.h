// A camera that orbits a target.
#ifndef QC_DEMOS_VIEW_CAMERA_H
#define QC_DEMOS_VIEW_CAMERA_H

#include <LinearMath/btVector3.h>

#include <array>

/// Column by column, as GL takes it.
using qcMatrix = std::array<float, 16>;

qcMatrix qcMultiply(const qcMatrix& a, const qcMatrix& b);
/// From world space to that of an eye that looks at a target.
qcMatrix qcLookAt(const btVector3& eye, const btVector3& target, const btVector3& up);
qcMatrix qcOrthographic(float halfWidth, float halfHeight, float near, float far);

class qcViewCamera
{
  public:
    void Place(const btVector3& eye, const btVector3& target);
    /// Angles in radians, to the right and upwards.
    void Orbit(btScalar right, btScalar up);
    /// Moves eye and target, in shares of the view's height.
    void Pan(btScalar right, btScalar up);
    /// Moves the eye to `factor` times its distance.
    void Zoom(btScalar factor);
    void LookAt(const btVector3& target);

    btVector3 Eye() const;
    const btVector3& Target() const
    {
        return m_target;
    }
    btScalar Distance() const
    {
        return m_distance;
    }
    /// From world to clip space. `extent`: of all that is drawn, around the target.
    qcMatrix ViewProjection(btScalar aspect, btScalar extent) const;
    /// The direction of a ray through a point of the view, -1..1 to the right and upwards. Unit length.
    btVector3 Ray(btScalar x, btScalar y, btScalar aspect) const;

  private:
    /// Unit vectors of the view: to the right, upwards, backwards.
    void Axes(btVector3 axes[3]) const;

    btVector3 m_target{0, 0, 0};
    btScalar m_distance = 5, m_yaw = 0, m_pitch = btScalar(0.4);
};

#endif
