import { Data3DTexture, HalfFloatType, Light, LinearFilter, RGBAFormat, Box3, Vector3 } from 'three';

export class LoadedProbes extends Light {
	constructor( file ) {
		super( 0xffffff, 1 );
		const halves = text => new Uint16Array( Uint8Array.from( atob( text ), c => c.charCodeAt( 0 ) ).buffer );
		const { width, height, depth, data } = file.atlas;
		this.isLightProbeGrid = true;
		this.texture = new Data3DTexture( halves( data ), width, height, depth );
		this.texture.format = RGBAFormat;
		this.texture.type = HalfFloatType;
		this.texture.minFilter = this.texture.magFilter = LinearFilter;
		this.texture.needsUpdate = true;
		this.boundingBox = new Box3( new Vector3( ...file.min ), new Vector3( ...file.max ) );
		this.resolution = new Vector3( ...file.resolution );
		this.priority = 0;
	}
}

// scene.add( ...await loadProbes( 'room.three.json' ) );
export async function loadProbes( url ) {
	const file = await ( await fetch( url ) ).json();
	return ( file.grids ?? [ file ] ).map( grid => new LoadedProbes( grid ) );
}

export { BrickProbes, loadBrickProbes } from './bricks.js'; // of '.ylmp'
