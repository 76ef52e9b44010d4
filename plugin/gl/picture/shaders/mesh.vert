#version 330 core
// Vertices of a mesh, for the eye or for the light.
in vec3 position;
in vec3 normal;
uniform mat4 clip;
out vec3 fromEye;
centroid out vec3 smoothNormal; // at slanted edges an extrapolated normal would point anywhere
void main()
{
    fromEye = position;
    smoothNormal = normal;
    gl_Position = clip * vec4(position, 1.0);
}
