#version 330 core
// The normal of what is drawn, towards the eye.
in vec3 fromEye;
centroid in vec3 smoothNormal;
uniform bool flatShading;
uniform bool edges;
vec3 findNormal()
{
    vec3 toEye = -normalize(fromEye);
    vec3 facet = cross(dFdx(fromEye), dFdy(fromEye)); // undefined for edges
    facet = !edges && dot(facet, facet) > 0.0 ? normalize(facet) : toEye;
    facet = dot(facet, toEye) < 0.0 ? -facet : facet;
    if (flatShading || dot(smoothNormal, smoothNormal) < 1e-6)
        return facet;
    vec3 n = normalize(smoothNormal);
    n = dot(n, facet) < 0.0 ? -n : n;
    // An averaged normal may point away from the eye at a silhouette: it is turned until it doesn't.
    return normalize(n + max(0.05 - dot(n, toEye), 0.0) * toEye);
}
